//! Writer of the row of `labels.csv` that describes a label; everything else in the file stays.

use std::io;
use std::path::Path;

use csv::WriterBuilder;
use grip_table::{Delimiter, Table, TableError};

use crate::csv_read::read_bytes;
use crate::error::CsvError;
use crate::labels::{Label, LabelError, LabelKind, read_labels};
use crate::outputs::replace;

/// Columns of a new file.
const COLUMNS: [&str; 4] = ["recording", "kind", "material", "onset_s"];

/// Place of the material in [`COLUMNS`].
const MATERIAL: usize = 2;

/// What stood there, and what is to be done with it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Relabel {
    /// A recording that has a label keeps it: nothing is written then.
    Keep,
    /// The new label takes its place.
    Replace,
    /// The label goes; what was given only names the recording.
    Remove,
}

/// Writes `label` into `file`, which is made where it is missing; gives the label that the recording had. Without a material the one that
/// stands there is kept. The file is replaced in one go.
///
/// # Errors
/// Where the file is no list of labels, or cannot be written.
pub fn write_label(
    file: &Path,
    label: &Label,
    relabel: Relabel,
) -> Result<Option<Label>, LabelError> {
    let before = match read_labels(file) {
        Ok(labels) => labels,
        Err(LabelError::Table(
            CsvError::Table(TableError::Empty { .. }) | CsvError::NoRows { .. },
        )) => Vec::new(),
        Err(LabelError::Table(CsvError::Unreadable { source, .. }))
            if source.kind() == io::ErrorKind::NotFound =>
        {
            Vec::new()
        }
        Err(error) => return Err(error),
    };
    let old = before.into_iter().find(|other| other.recording == label.recording);
    if relabel == Relabel::Keep && old.is_some() || relabel == Relabel::Remove && old.is_none() {
        return Ok(old);
    }
    let unwritable = |source: io::Error| CsvError::Unreadable { file: file.to_owned(), source };
    let bytes = if file.exists() { read_bytes(file)? } else { Vec::new() };
    let (mut rows, delimiter) = rows(file, &bytes)?;
    put(&mut rows, label, relabel);
    let text = joined(&rows, delimiter).map_err(unwritable)?;
    replace(file, text).map_err(unwritable)?;
    Ok(old)
}

/// The header and the rows, each as wide as the header, and what stands between two cells.
fn rows(file: &Path, bytes: &[u8]) -> Result<(Vec<Vec<String>>, u8), CsvError> {
    if bytes.trim_ascii().is_empty() {
        return Ok((vec![COLUMNS.map(str::to_owned).to_vec()], b','));
    }
    let mut table = Table::by_hand(file, bytes)?;
    let delimiter = match table.delimiter() {
        Delimiter::Byte(byte) => byte,
        Delimiter::Blanks => b',',
    };
    let mut rows = vec![table.columns().iter().map(|column| column.given.clone()).collect()];
    let width = table.columns().len();
    while let Some(row) = table.next_row()? {
        rows.push((0..width).map(|column| row.cell(column).into_owned()).collect());
    }
    Ok((rows, delimiter))
}

fn put(rows: &mut Vec<Vec<String>>, label: &Label, relabel: Relabel) {
    let onset = match label.kind {
        LabelKind::Onset { at } => format!("{}.{:06}", at.0 / 1_000_000, at.0 % 1_000_000),
        LabelKind::Steady | LabelKind::Rest => String::new(),
    };
    let cells = [label.recording.as_str(), label.kind.word(), &label.material, &onset];
    let places = COLUMNS.map(|name| place(rows, name));
    let [recording, ..] = places;
    let is_its =
        |row: &Vec<String>| row.get(recording).is_some_and(|cell| *cell == label.recording);
    let at = rows.iter().skip(1).position(is_its).map(|at| at + 1);
    let mut place = 0..;
    // Further onsets go.
    rows.retain(|row| {
        let place = place.next();
        place == Some(0) || !is_its(row) || (place == at && relabel != Relabel::Remove)
    });
    if relabel == Relabel::Remove {
        return;
    }
    let width = rows.first().map_or(0, Vec::len);
    let at = at.unwrap_or_else(|| {
        rows.push(vec![String::new(); width]);
        rows.len() - 1
    });
    for (at_cell, (place, cell)) in places.into_iter().zip(cells).enumerate() {
        // A new label without a material does not take the known one away.
        if at_cell == MATERIAL && cell.is_empty() {
            continue;
        }
        if let Some(place) = rows.get_mut(at).and_then(|row| row.get_mut(place)) {
            cell.clone_into(place);
        }
    }
}

/// Place of the column `name`, which is added where it is missing.
fn place(rows: &mut [Vec<String>], name: &str) -> usize {
    let header = rows.first().map_or(&[] as &[String], Vec::as_slice);
    let (width, found) = (header.len(), header.iter().position(|cell| cell == name));
    if found.is_none() {
        for (at, row) in rows.iter_mut().enumerate() {
            row.resize(width, String::new());
            row.push(if at == 0 { name.to_owned() } else { String::new() });
        }
    }
    found.unwrap_or(width)
}

fn joined(rows: &[Vec<String>], delimiter: u8) -> io::Result<Vec<u8>> {
    let mut writer =
        WriterBuilder::new().delimiter(delimiter).flexible(true).from_writer(Vec::new());
    for row in rows {
        writer.write_record(row)?;
    }
    writer.into_inner().map_err(|error| io::Error::other(error.to_string()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use slip_core::units::Micros;
    use std::fs;

    fn label(name: &str, kind: LabelKind) -> Label {
        Label { recording: name.to_owned(), kind, material: "cork, rough".to_owned() }
    }

    #[test]
    fn a_label_is_added_replaced_and_removed_and_the_rest_stays() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("labels.csv");
        let onset = label("a", LabelKind::Onset { at: Micros(1_250_000) });
        assert_eq!(write_label(&file, &onset, Relabel::Keep).unwrap(), None);
        assert_eq!(read_labels(&file).unwrap(), core::slice::from_ref(&onset));

        fs::write(&file, "note,recording,kind\nmine,b,steady\n\"x,y\",c,rest\n").unwrap();
        assert_eq!(write_label(&file, &onset, Relabel::Keep).unwrap(), None);
        let rest = label("b", LabelKind::Rest);
        let old = write_label(&file, &rest, Relabel::Keep).unwrap();
        assert_eq!(old.map(|old| old.kind), Some(LabelKind::Steady));
        write_label(&file, &rest, Relabel::Replace).unwrap();
        let text = fs::read_to_string(&file).unwrap();
        let expected = "note,recording,kind,material,onset_s\nmine,b,rest,\"cork, rough\",\n\
            \"x,y\",c,rest,,\n,a,onset,\"cork, rough\",1.250000\n";
        assert_eq!(text, expected);
        let silent = Label { material: String::new(), ..rest.clone() };
        write_label(&file, &silent, Relabel::Replace).unwrap();
        assert_eq!(fs::read_to_string(&file).unwrap(), expected, "without one the material stays");
        write_label(&file, &rest, Relabel::Remove).unwrap();
        write_label(&file, &rest, Relabel::Remove).unwrap();
        assert_eq!(read_labels(&file).unwrap().len(), 2);
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1, "nothing is left beside it");

        fs::write(&file, "recording,kind,onset_s\na,onset,1\nb,rest,\na,onset,2\n").unwrap();
        write_label(&file, &label("a", LabelKind::Steady), Relabel::Replace).unwrap();
        let kinds = |file| read_labels(file).unwrap().iter().map(|l| l.kind).collect::<Vec<_>>();
        assert_eq!(kinds(&file), [LabelKind::Steady, LabelKind::Rest], "all its onsets");

        fs::write(&file, "\u{feff}recording;kind;onset_s\r\na;onset;1,5\r\nb;steady;").unwrap();
        let old = write_label(&file, &rest, Relabel::Replace).unwrap();
        assert_eq!(old.map(|old| old.kind), Some(LabelKind::Steady));
        let text = fs::read_to_string(&file).unwrap();
        assert_eq!(text, "recording;kind;onset_s;material\na;onset;1,5;\nb;rest;;cork, rough\n");

        fs::write(&file, "no,list\n1,2\n").unwrap();
        assert!(write_label(&file, &rest, Relabel::Replace).is_err());
        assert_eq!(fs::read_to_string(&file).unwrap(), "no,list\n1,2\n");
    }
}
