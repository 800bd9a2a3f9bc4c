//! The column of a quantity, found by names and units.

use crate::{Column, Quantity, Table, TableError, of_name, scale};

impl<R> Table<R> {
    /// The column of a quantity, and how much of the base unit one of its numbers is: `name_unit` itself, of the first of
    /// `names`, or the same name with another unit of the quantity behind or below it (`height_mm`, `Height [nm]` for
    /// `height`, `um`); otherwise the only column with one of the further names and a unit of the quantity.
    ///
    /// # Errors
    /// Where there is none, or its unit is absent, not known or of something else.
    pub fn quantity(&self, names: &[&str], unit: &str) -> Result<(usize, f64), TableError> {
        let (name, others) = names.split_first().unwrap_or((&"", &[]));
        let wanted = format!("{name}_{unit}");
        let (quantity, factor) = scale(unit).unwrap_or((Quantity::Length, 1.0));
        let is_called = |column: &Column, name: &str| {
            let bare = of_name(&column.given).map_or(column.given.clone(), |(bare, _)| bare);
            bare.to_lowercase() == *name
        };
        let fits = |column: &Column| {
            let scale = column.unit.as_deref().and_then(scale);
            scale.filter(|(found, _)| *found == quantity)
        };
        let only = |is_it: &dyn Fn(&Column) -> bool| {
            let mut found = self.columns().iter().enumerate().filter(|(_, column)| {
                others.iter().any(|name| is_called(column, name)) && is_it(column)
            });
            found.next().map(|(at, _)| at).filter(|_| found.next().is_none())
        };
        // An ending behind an underscore that is no known unit.
        let ending = |column: &Column| {
            let (before, ending) = column.given.rsplit_once('_')?;
            names.contains(&before.to_lowercase().as_str()).then(|| ending.to_owned())
        };
        let position = |is_it: &dyn Fn(&Column) -> bool| self.columns().iter().position(is_it);
        let found = self
            .position(&wanted)
            .or_else(|| position(&|column| is_called(column, name)))
            .or_else(|| only(&|column| fits(column).is_some()))
            .or_else(|| only(&|_| true))
            .or_else(|| position(&|column| ending(column).is_some()));
        let Some((at, column)) = found.and_then(|at| Some((at, self.columns().get(at)?))) else {
            self.check_repeated(|column| column == wanted)?;
            return Err(self.missing(wanted, names));
        };
        self.check_repeated(|given| *given == column.given)?;
        if column.name == wanted {
            return Ok((at, factor));
        }
        if let Some((_, factor)) = fits(column) {
            return Ok((at, factor));
        }
        let (file, column_name) = (self.file.clone(), column.name.clone());
        Err(match column.unit.clone().or_else(|| ending(column)) {
            None => TableError::NoUnit {
                file,
                wanted: format!("{}_{unit}", column.given),
                column: column_name,
            },
            Some(unit) => {
                TableError::Unit { file, column: column_name, unit, wanted: quantity.words() }
            }
        })
    }

    pub(crate) fn missing(&self, wanted: String, names: &[&str]) -> TableError {
        let names = names.iter().map(|name| (*name).to_owned()).collect();
        TableError::Missing { file: self.file.clone(), wanted, names, found: self.names.clone() }
    }
}
