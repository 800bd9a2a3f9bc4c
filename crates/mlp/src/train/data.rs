//! Data set: feature and target rows from bytes of a CSV file or arrays, by column specs.

use grip_table::{Loss, Row, Table};
use ndarray::{Array2, ArrayView1, ArrayView2, Axis};
use sha2::{Digest, Sha256};

use super::column::ColumnSpec;
pub use super::data_error::{DataSetError, Place};
use super::objective::count;
use super::scaling::{Method, Scaling};
use super::topology::{MOST_INPUTS, MOST_OUTPUTS};
use crate::model::Transform;

/// What a classifier distinguishes.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Classes {
    /// The column whose text is the class of a row.
    pub column: String,
    /// The classes. Where none are named, those that the rows show, in alphabetical order.
    pub names: Vec<String>,
}

/// Features and targets of one file in raw units, row by row; all values are finite in single precision too.
#[derive(Debug, Clone, PartialEq)]
pub struct DataSet {
    /// Name of the file, for messages.
    pub file: String,
    /// SHA-256 of the file's bytes in hexadecimal; of computed rows see [`DataSet::from_values`].
    pub sha256: String,
    /// Feature columns in the order asked for.
    pub inputs: Vec<ColumnSpec>,
    /// Target columns in the order asked for.
    pub targets: Vec<ColumnSpec>,
    /// The column whose text is the class of a row; targets are then the classes, 1 for a row's own and 0 for the others.
    pub classes: Option<String>,
    /// Rows x inputs, at least one row.
    input_values: Array2<f64>,
    /// As many rows x targets.
    target_values: Array2<f64>,
    /// One label a row, or none at all.
    labels: Vec<String>,
    /// What of the file is no row and was left out: a last line that was cut off, a remark behind the rows.
    pub left_out: Vec<Loss>,
}

impl DataSet {
    /// Reads the wanted columns of a CSV file with a header row. `file` is its name, used in messages.
    ///
    /// # Errors
    /// Any [`DataSetError`]; the first fault ends the reading.
    pub fn from_csv(
        file: &str,
        bytes: &[u8],
        inputs: &[ColumnSpec],
        targets: &[ColumnSpec],
    ) -> Result<Self, DataSetError> {
        Self::from_grouped_csv(file, bytes, inputs, targets, None)
    }

    /// The same for the columns `inputs` and `targets`, and of each row the text in the column `group` (an object, a
    /// grasp, a session): rows with the same one stay together in a [split](super::split).
    ///
    /// # Errors
    /// Any [`DataSetError`]; the first fault ends the reading.
    pub fn from_grouped_csv(
        file: &str,
        bytes: &[u8],
        inputs: &[ColumnSpec],
        targets: &[ColumnSpec],
        group: Option<&str>,
    ) -> Result<Self, DataSetError> {
        check_columns(inputs, targets)?;
        let read = read_csv(file, bytes, inputs, targets, group.as_slice())?;
        Ok(Self {
            file: file.to_owned(),
            sha256: sha256(bytes),
            inputs: inputs.to_vec(),
            targets: targets.to_vec(),
            classes: None,
            input_values: read.inputs,
            target_values: read.targets,
            labels: read.texts.into_iter().next().unwrap_or_default(),
            left_out: read.left_out,
        })
    }

    /// The same for rows whose target is a class.
    ///
    /// # Errors
    /// Any [`DataSetError`]; the first fault ends the reading.
    pub fn from_class_csv(
        file: &str,
        bytes: &[u8],
        inputs: &[ColumnSpec],
        classes: &Classes,
        group: Option<&str>,
    ) -> Result<Self, DataSetError> {
        check_columns(inputs, &[class_column(classes)])?;
        let names = [Some(classes.column.as_str()), group];
        let names: Vec<&str> = names.into_iter().flatten().collect();
        let read = read_csv(file, bytes, inputs, &[], &names)?;
        let mut texts = read.texts.into_iter();
        let of_rows = texts.next().unwrap_or_default();
        let data = Self::from_classes(file, inputs, read.inputs, classes, &of_rows)?;
        let (labels, left_out) = (texts.next().unwrap_or_default(), read.left_out);
        Ok(Self { sha256: sha256(bytes), labels, left_out, ..data })
    }

    /// Data that was computed, or read from another kind of file: raw features (rows x inputs) and targets (rows x targets) of
    /// any memory layout. `name` is used in messages, with the number of the row (from 1) as the line. The hash is that of the
    /// values' bytes, little-endian, row by row, features first.
    ///
    /// # Errors
    /// [`DataSetError::Columns`], [`DataSetError::Repeated`], [`DataSetError::Shape`], [`DataSetError::NoRows`],
    /// [`DataSetError::NotANumber`] and [`DataSetError::NotPositive`].
    pub fn from_values(
        name: &str,
        inputs: &[ColumnSpec],
        targets: &[ColumnSpec],
        input_values: Array2<f64>,
        target_values: Array2<f64>,
    ) -> Result<Self, DataSetError> {
        check_columns(inputs, targets)?;
        let columns = [inputs.len(), targets.len()];
        let (x, y) = (input_values.dim(), target_values.dim());
        if [x.1, y.1] != columns || x.0 != y.0 {
            let (inputs, targets) = (x.into(), y.into());
            return Err(DataSetError::Shape { name: name.to_owned(), inputs, targets, columns });
        }
        if x.0 == 0 {
            return Err(DataSetError::NoRows { file: name.to_owned() });
        }
        for (specs, values) in [(inputs, &input_values), (targets, &target_values)] {
            for (at, (&value, spec)) in values.iter().zip(specs.iter().cycle()).enumerate() {
                check(value, spec, || {
                    let (file, column) = (name.to_owned(), spec.name.clone());
                    let line = (at / specs.len() + 1) as u64;
                    (Place { file, line, column }, value.to_string())
                })?;
            }
        }
        let values = input_values.iter().chain(&target_values);
        let bytes: Vec<u8> = values.flat_map(|value| value.to_le_bytes()).collect();
        Ok(Self {
            file: name.to_owned(),
            sha256: sha256(&bytes),
            inputs: inputs.to_vec(),
            targets: targets.to_vec(),
            classes: None,
            input_values,
            target_values,
            labels: Vec::new(),
            left_out: Vec::new(),
        })
    }

    /// The same for rows whose target is a class, one text for each row.
    ///
    /// # Errors
    /// As [`DataSet::from_values`]; [`DataSetError::Labels`] unless there is a text a row, [`DataSetError::Classes`] and
    /// [`DataSetError::UnknownClass`].
    pub fn from_classes(
        name: &str,
        inputs: &[ColumnSpec],
        values: Array2<f64>,
        classes: &Classes,
        texts: &[String],
    ) -> Result<Self, DataSetError> {
        let column = class_column(classes);
        check_columns(inputs, core::slice::from_ref(&column))?;
        let mut names = classes.names.clone();
        if names.is_empty() {
            names = texts.to_vec();
            names.sort_unstable();
            names.dedup();
        }
        if !(2..=MOST_OUTPUTS).contains(&names.len()) {
            return Err(DataSetError::Classes { column: column.name, given: names.len() });
        }
        let place = |(row, text): (usize, &String)| {
            names.iter().position(|name| name == text).ok_or_else(|| DataSetError::UnknownClass {
                file: name.to_owned(),
                row: row + 1,
                class: text.clone(),
                known: names.join(", "),
            })
        };
        let places: Vec<usize> = texts.iter().enumerate().map(place).collect::<Result<_, _>>()?;
        let number = Array2::from_shape_fn((places.len(), 1), |(row, _)| count(places[row]));
        let one_hot = Array2::from_shape_fn((places.len(), names.len()), |(row, class)| {
            f64::from(u8::from(places[row] == class))
        });
        let data = Self::from_values(name, inputs, &[column], values, number)?;
        let class = |name: String| ColumnSpec { name, transform: Transform::Identity };
        Ok(Self {
            targets: names.into_iter().map(class).collect(),
            classes: Some(classes.column.clone()),
            target_values: one_hot,
            ..data
        })
    }

    /// The same rows with a label each: rows with the same one stay together in a [split](super::split).
    ///
    /// # Errors
    /// [`DataSetError::Labels`] unless there is one a row, [`DataSetError::NoLabel`] where one is empty.
    pub fn with_labels(self, labels: Vec<String>) -> Result<Self, DataSetError> {
        if labels.len() != self.rows() {
            let (rows, labels) = (self.rows(), labels.len());
            return Err(DataSetError::Labels { name: self.file, labels, rows });
        }
        if let Some(at) = labels.iter().position(String::is_empty) {
            let (file, line) = (self.file, at as u64 + 1);
            let place = Place { file, line, column: "label".to_owned() };
            return Err(DataSetError::NoLabel { place });
        }
        Ok(Self { labels, ..self })
    }

    /// The given rows, counted from 0, in the given order. Name and hash stay those of the whole.
    ///
    /// # Errors
    /// [`DataSetError::NoRows`] and [`DataSetError::NoSuchRow`].
    pub fn subset(&self, rows: &[usize]) -> Result<Self, DataSetError> {
        if rows.is_empty() {
            return Err(DataSetError::NoRows { file: self.file.clone() });
        }
        if let Some(&row) = rows.iter().find(|row| **row >= self.rows()) {
            return Err(DataSetError::NoSuchRow { row, rows: self.rows() });
        }
        Ok(Self {
            file: self.file.clone(),
            sha256: self.sha256.clone(),
            inputs: self.inputs.clone(),
            targets: self.targets.clone(),
            classes: self.classes.clone(),
            input_values: self.input_values.select(Axis(0), rows),
            target_values: self.target_values.select(Axis(0), rows),
            labels: rows.iter().filter_map(|row| self.labels.get(*row).cloned()).collect(),
            left_out: self.left_out.clone(),
        })
    }

    /// The label of each row, or none where no column of labels was read.
    #[must_use]
    pub fn labels(&self) -> &[String] {
        &self.labels
    }

    /// Number of rows, at least 1.
    #[must_use]
    pub fn rows(&self) -> usize {
        self.input_values.nrows()
    }

    /// Raw features, rows x inputs.
    #[must_use]
    pub fn input_values(&self) -> ArrayView2<'_, f64> {
        self.input_values.view()
    }

    /// Raw targets, rows x targets.
    #[must_use]
    pub fn target_values(&self) -> ArrayView2<'_, f64> {
        self.target_values.view()
    }

    /// Features and targets of each row, raw.
    #[must_use]
    pub fn iter(
        &self,
    ) -> impl ExactSizeIterator<Item = (ArrayView1<'_, f64>, ArrayView1<'_, f64>)> {
        self.input_values.rows().into_iter().zip(self.target_values.rows())
    }

    /// Limits of the feature columns over the rows, for min-max.
    #[must_use]
    pub fn input_scalings(&self) -> Vec<Scaling> {
        self.scalings(Method::MinMax).0
    }

    /// Limits of the target columns over the rows, for min-max.
    #[must_use]
    pub fn target_scalings(&self) -> Vec<Scaling> {
        self.scalings(Method::MinMax).1
    }

    /// Limits of feature and target columns over the rows, scaled by `method`. Those of classes leave them as they are.
    #[must_use]
    pub fn scalings(&self, method: Method) -> (Vec<Scaling>, Vec<Scaling>) {
        let targets = match self.classes {
            None => scalings(method, &self.targets, &self.target_values),
            Some(_) => vec![Scaling::of(Transform::Identity, [-1.0, 1.0]); self.targets.len()],
        };
        (scalings(method, &self.inputs, &self.input_values), targets)
    }

    /// The same rows with the target taken through `transform`; none unless there is one target, a number that the transform takes in
    /// every row.
    #[must_use]
    pub fn with_target(&self, transform: Transform) -> Option<Self> {
        let [target] = &self.targets[..] else { return None };
        let taken = transform == Transform::Identity || self.target_values.iter().all(|y| *y > 0.0);
        let targets = vec![ColumnSpec { transform, ..target.clone() }];
        (taken && self.classes.is_none()).then(|| Self { targets, ..self.clone() })
    }

    /// The forms of the target that evidence or folds may choose between: as it was asked for and, where that is a positive number,
    /// its logarithm and its reciprocal.
    #[must_use]
    pub fn target_forms(&self) -> Vec<Self> {
        let others = [Transform::Ln, Transform::Reciprocal].map(|form| self.with_target(form));
        let others = others.into_iter().flatten().filter(|form| form.targets != self.targets);
        core::iter::once(self.clone()).chain(others).collect()
    }

    /// Logarithm of the density of the raw targets over that of the scaled ones: added to an evidence in scaled units it makes those of
    /// several [forms](Self::target_forms) comparable.
    #[must_use]
    pub fn ln_jacobian(&self) -> f64 {
        let scalings = self.target_scalings();
        let rows = self.target_values.rows();
        let ln = |(y, scaling): (&f64, &Scaling)| {
            (2.0 * scaling.column.transform.slope(*y) / scaling.span()).ln()
        };
        rows.into_iter().map(|row| row.iter().zip(&scalings).map(ln).sum::<f64>()).sum()
    }

    /// Inputs and targets of all rows scaled, as the [objective](super::NetworkObjective) takes them. Limits come from the
    /// training rows, whichever rows these are; a column without limits stays raw.
    #[must_use]
    pub fn scaled(&self, inputs: &[Scaling], targets: &[Scaling]) -> [Array2<f64>; 2] {
        [scaled(inputs, &self.input_values), scaled(targets, &self.target_values)]
    }
}

fn class_column(classes: &Classes) -> ColumnSpec {
    ColumnSpec { name: classes.column.clone(), transform: Transform::Identity }
}

fn check_columns(inputs: &[ColumnSpec], targets: &[ColumnSpec]) -> Result<(), DataSetError> {
    for (kind, specs, limit) in [("input", inputs, MOST_INPUTS), ("target", targets, MOST_OUTPUTS)]
    {
        if !(1..=limit).contains(&specs.len()) {
            return Err(DataSetError::Columns { kind, given: specs.len(), limit });
        }
    }
    let all: Vec<&ColumnSpec> = inputs.iter().chain(targets).collect();
    for (place, spec) in all.iter().enumerate() {
        if all[..place].iter().any(|other| other.name == spec.name) {
            return Err(DataSetError::Repeated { column: spec.name.clone() });
        }
    }
    Ok(())
}

/// What the wanted columns of a file hold.
struct CsvRows {
    inputs: Array2<f64>,
    targets: Array2<f64>,
    /// The texts of each column of texts.
    texts: Vec<Vec<String>>,
    left_out: Vec<Loss>,
}

/// The number of a column.
fn column(file: &str, table: &Table<&[u8]>, name: &str) -> Result<usize, DataSetError> {
    table.check_repeated(|repeated| repeated == name)?;
    table.position(name).ok_or_else(|| DataSetError::Missing {
        file: file.to_owned(),
        column: name.to_owned(),
        available: grip_table::list(table.header()),
    })
}

fn read_csv(
    file: &str,
    bytes: &[u8],
    inputs: &[ColumnSpec],
    targets: &[ColumnSpec],
    texts: &[&str],
) -> Result<CsvRows, DataSetError> {
    let mut table = Table::open(file.as_ref(), bytes)?;
    let at = |name: &str, table: &Table<&[u8]>| column(file, table, name);
    let places = |specs: &[ColumnSpec], table: &Table<&[u8]>| {
        specs.iter().map(|spec| at(&spec.name, table)).collect::<Result<Vec<_>, _>>()
    };
    let (input_places, target_places) = (places(inputs, &table)?, places(targets, &table)?);
    let text_places = texts.iter().map(|name| at(name, &table)).collect::<Result<Vec<_>, _>>()?;
    let (mut rows, mut labels) = (0, vec![Vec::new(); texts.len()]);
    let (mut input_values, mut target_values) = (Vec::new(), Vec::new());
    while let Some(row) = table.next_row()? {
        read_fields(&row, &input_places, inputs, &mut input_values)?;
        read_fields(&row, &target_places, targets, &mut target_values)?;
        for (labels, &at) in labels.iter_mut().zip(&text_places) {
            labels.push(read_label(&row, at)?);
        }
        rows += 1;
    }
    let no_rows = || DataSetError::NoRows { file: file.to_owned() };
    if rows == 0 {
        return Err(no_rows());
    }
    // Each row has put a value for every column by, so the arrays have these shapes.
    let array =
        |columns, values| Array2::from_shape_vec((rows, columns), values).map_err(|_| no_rows());
    let (inputs, targets) =
        (array(inputs.len(), input_values)?, array(targets.len(), target_values)?);
    let left_out = table.losses().to_vec();
    Ok(CsvRows { inputs, targets, texts: labels, left_out })
}

fn place(row: &Row<'_>, column: usize) -> Place {
    let file = row.file().display().to_string();
    Place { file, line: row.line, column: row.name(column) }
}

fn read_fields(
    row: &Row<'_>,
    places: &[usize],
    specs: &[ColumnSpec],
    values: &mut Vec<f64>,
) -> Result<(), DataSetError> {
    for (&at, spec) in places.iter().zip(specs) {
        let value = match row.number(at) {
            // A number of another form, which the reader of tables explains.
            Err(error) if row.cell(at).contains([',', '.', '\'']) => return Err(error.into()),
            number => number.unwrap_or(f64::NAN),
        };
        check(value, spec, || (place(row, at), row.cell(at).into_owned()))?;
        values.push(value);
    }
    Ok(())
}

/// Whether `value` is a number in single precision and its column's transform takes it; `at` gives its place and text.
fn check(
    value: f64,
    spec: &ColumnSpec,
    at: impl FnOnce() -> (Place, String),
) -> Result<(), DataSetError> {
    let (single, transform) = (super::rounded(value), spec.transform);
    if !single.is_finite() {
        let (place, text) = at();
        return Err(DataSetError::NotANumber { place, text });
    }
    // A positive value that is 0 in the model's precision has neither logarithm nor reciprocal there.
    if !transform.accepts(single) {
        return Err(DataSetError::NotPositive { place: at().0, transform, value });
    }
    Ok(())
}

fn read_label(row: &Row<'_>, at: usize) -> Result<String, DataSetError> {
    match row.cell(at).into_owned() {
        label if label.is_empty() => Err(DataSetError::NoLabel { place: place(row, at) }),
        label => Ok(label),
    }
}

fn scalings(method: Method, specs: &[ColumnSpec], values: &Array2<f64>) -> Vec<Scaling> {
    let columns = specs.iter().zip(values.columns());
    columns
        .map(|(spec, column)| Scaling::by(method, spec.transform, &column.iter().copied()))
        .collect()
}

fn scaled(scalings: &[Scaling], values: &Array2<f64>) -> Array2<f64> {
    let mut values = values.clone();
    for (mut column, scaling) in values.columns_mut().into_iter().zip(scalings) {
        column.mapv_inplace(|raw| scaling.scaled(raw));
    }
    values
}

/// SHA-256 of `bytes` in hexadecimal, as [`DataSet::sha256`] has it.
#[must_use]
pub fn sha256(bytes: &[u8]) -> String {
    Sha256::digest(bytes).iter().map(|byte| format!("{byte:02x}")).collect()
}

#[cfg(test)]
mod tests;
