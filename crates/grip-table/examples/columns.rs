//! What is found in a table: `cargo run -p grip-table --example columns -- FILE`
#![expect(clippy::print_stdout, reason = "what it is for")]

use core::error::Error;
use grip_table::Table;
use std::{env, fs::File, path::PathBuf};

fn main() -> Result<(), Box<dyn Error>> {
    let file = PathBuf::from(env::args_os().nth(1).ok_or("FILE is missing")?);
    let mut table = Table::open(&file, File::open(&file)?)?;
    let columns = table.columns().to_vec();
    let mut sums = vec![0.0; columns.len()];
    let mut rows = 0_u32;
    while let Some(row) = table.next_row()? {
        rows += 1;
        for (at, sum) in sums.iter_mut().enumerate().filter(|(at, _)| !columns[*at].is_text) {
            *sum += row.value(at)?.filter(|value| value.is_finite()).unwrap_or(0.0);
        }
    }
    println!("{rows} rows");
    for (column, sum) in columns.iter().zip(sums) {
        let unit = column.unit.as_deref().unwrap_or("-");
        let kind = if column.is_text {
            "text".to_owned()
        } else {
            format!("mean {}", sum / f64::from(rows))
        };
        println!("{} ({unit}): {kind}", column.name);
    }
    table.losses().iter().for_each(|loss| println!("{loss}"));
    Ok(())
}
