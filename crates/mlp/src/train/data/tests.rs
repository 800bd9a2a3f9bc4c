use super::*;
use ndarray::{ArrayView, ShapeBuilder as _, arr1, arr2};

fn specs(texts: &[&str]) -> Vec<ColumnSpec> {
    texts.iter().map(|text| text.parse().unwrap()).collect()
}

fn read(csv: &str, inputs: &[&str], targets: &[&str]) -> Result<DataSet, DataSetError> {
    DataSet::from_csv("grasps.csv", csv.as_bytes(), &specs(inputs), &specs(targets))
}

fn message(csv: &str, inputs: &[&str]) -> String {
    read(csv, inputs, &["f_n"]).unwrap_err().to_string()
}

#[test]
fn columns_are_found_by_name_and_scaled() {
    let csv = "\u{feff}f_n, note ,v_m_s\n1,a,0.1\r\n\n3,\"b,c\",0.3\n2,,0.2\n";
    let data = read(csv, &["v_m_s"], &["f_n:ln"]).unwrap();
    assert_eq!(data.rows(), 3);
    let raw: Vec<_> = data.iter().map(|(x, y)| (x.to_vec(), y.to_vec())).collect();
    assert_eq!(raw[1], (vec![0.3], vec![3.0]));
    let [_, targets] = data.scaled(&data.input_scalings(), &data.target_scalings());
    let expected = [-1.0, 1.0, 2.0 * 2_f64.ln() / 3_f64.ln() - 1.0];
    for (scaled, expected) in targets.iter().zip(expected) {
        assert!((scaled - expected).abs() < 1e-15, "{scaled} {expected}");
    }
}

#[test]
fn the_hash_is_that_of_the_bytes() {
    let data = read("x,y\n1,2\n", &["x"], &["y"]).unwrap();
    // As `printf 'x,y\n1,2\n' | sha256sum` states.
    let known = "81bf9fa83c6f7f151bd491a98cd7d933de3965289e3ebd77c6c425f7eaa16392";
    assert_eq!(data.sha256, known);
}

#[test]
fn messages_say_where_and_what() {
    assert_eq!(
        message("v,f_n\n1,2\n", &["speed"]),
        "grasps.csv: no column \"speed\" (there are: v, f_n)"
    );
    assert_eq!(
        message("9.3e-2,1.377\n1,2\n", &["v"]),
        "grasps.csv: no column \"v\" (there are: column_0, column_1); its first line is numbers: use these names, or put names above the numbers"
    );
    assert_eq!(
        message("v,f_n\n1,2\n\nfast,3\n", &["v"]),
        "grasps.csv, line 4, column \"v\": \"fast\" is not a number within +-3.4e38; fill the cell or remove the row"
    );
    assert_eq!(
        message("v,f_n\n1,2\n3\n4,5\n", &["v"]),
        "grasps.csv: line 3: 1 fields where the header names 2; add the missing fields (an empty one is a comma)"
    );
    assert_eq!(
        message("v,f_n\n0.5,2\n0,3\n", &["v:ln"]),
        "grasps.csv, line 3, column \"v\": ln needs a value above 0, this is 0"
    );
    assert!(message("v,v,f_n\n1,1,1\n", &["v"]).contains("columns 1 and 2 are both named \"v\""));
    assert_eq!(message("v,f_n\n", &["v"]), "grasps.csv: no rows below the header");
    assert!(message("", &["v"]).starts_with("grasps.csv: is empty"));
    assert_eq!(message("v,f_n\n1,1\n", &["f_n"]), "column \"f_n\" is used twice");
    assert!(matches!(
        read("x,y\n1,2\n", &[], &["y"]),
        Err(DataSetError::Columns { kind: "input", given: 0, limit: 1024 })
    ));
}

#[test]
fn what_is_not_finite_is_refused() {
    for text in ["NaN", "nan", "inf", "-inf", "1e999", "1e39", "", "x"] {
        let csv = format!("v,f_n\n\"{text}\",1\n");
        let error = read(&csv, &["v"], &["f_n"]).unwrap_err();
        assert!(matches!(error, DataSetError::NotANumber { .. }), "{text}: {error}");
    }
}

#[test]
fn rows_are_read_as_other_tables_are() {
    let text = "run 7\ngrasp;v;f_n\na;0,1;1\nb;0,2;2\nc;0,3;3\nd;0,";
    let (v, f_n) = (specs(&["v"]), specs(&["f_n"]));
    let data =
        DataSet::from_grouped_csv("g.csv", text.as_bytes(), &v, &f_n, Some("grasp")).unwrap();
    assert_eq!(
        (data.labels(), data.input_values()[[2, 0]]),
        (&["a", "b", "c"].map(str::to_owned)[..], 0.3)
    );
    assert_eq!(data.left_out[0].to_string(), "line 6 was cut off and is left out: \"d;0,\"");
    assert!(message("v,f_n\n\"1,250\",1\n2,2\n", &["v"]).contains("thousands"));
    assert!(message("\u{1f}\u{8b}\u{8}", &["v"]).contains("is no text"));
}

#[test]
fn labels_are_read_beside_the_numbers() {
    let csv = "grasp,v,f_n\na 1,1,2\nb,2,3\na 1,3,4\n";
    let (inputs, targets) = (specs(&["v"]), specs(&["f_n"]));
    let read = |csv: &str, group| {
        DataSet::from_grouped_csv("grasps.csv", csv.as_bytes(), &inputs, &targets, Some(group))
    };
    let data = read(csv, "grasp").unwrap();
    assert_eq!(data.labels(), ["a 1", "b", "a 1"]);
    let part = data.subset(&[2, 0]).unwrap();
    assert_eq!((part.rows(), part.labels().len(), &part.sha256), (2, 2, &data.sha256));
    assert_eq!(part.iter().next().unwrap(), (arr1(&[3.0]).view(), arr1(&[4.0]).view()));
    let error = data.subset(&[1, 3]).unwrap_err();
    assert_eq!(error, DataSetError::NoSuchRow { row: 3, rows: 3 });
    assert!(matches!(data.subset(&[]), Err(DataSetError::NoRows { .. })));
    assert_eq!(
        read("grasp,v,f_n\na,1,2\n ,2,3\n", "grasp").unwrap_err().to_string(),
        "grasps.csv, line 3, column \"grasp\": a label is needed to split by it"
    );
    assert_eq!(
        read(csv, "object").unwrap_err().to_string(),
        "grasps.csv: no column \"object\" (there are: grasp, v, f_n)"
    );
    // A column may label and be a feature.
    assert_eq!(read(csv, "v").unwrap().labels(), ["1", "2", "3"]);
}

#[test]
fn computed_values_are_checked_like_fields() {
    let make = |inputs: Array2<f64>, targets: Array2<f64>| {
        DataSet::from_values("rows", &specs(&["v", "n:ln"]), &specs(&["f_n"]), inputs, targets)
    };
    let (x, y) = (arr2(&[[0.1, 1.0], [0.2, 2.0]]), arr2(&[[3.0], [4.0]]));
    let data = make(x.clone(), y.clone()).unwrap();
    assert_eq!((data.rows(), data.labels().len()), (2, 0));
    let file = read("v,n,f_n\n0.1,1,3\n0.2,2,4\n", &["v", "n:ln"], &["f_n"]).unwrap();
    assert!(data.iter().eq(file.iter()));
    assert_eq!(data.input_scalings(), file.input_scalings());
    let error = make(x.clone(), arr2(&[[3.0]])).unwrap_err();
    assert_eq!(
        error.to_string(),
        "rows: inputs of 2 x 2 and targets of 1 x 1: as many rows of both are needed, 2 and 1 columns"
    );
    assert!(matches!(make(y.clone(), y.clone()), Err(DataSetError::Shape { .. })));
    let none = make(Array2::zeros((0, 2)), Array2::zeros((0, 1)));
    assert!(matches!(none, Err(DataSetError::NoRows { .. })));
    for bad in [f64::NAN, f64::INFINITY, 1e39] {
        let error = make(arr2(&[[0.1, 1.0], [bad, 2.0]]), y.clone()).unwrap_err();
        assert!(error.to_string().starts_with("rows, line 2, column \"v\""), "{error}");
    }
    let error = make(arr2(&[[0.1, 0.0]]), arr2(&[[3.0]])).unwrap_err();
    assert!(matches!(error, DataSetError::NotPositive { .. }), "{error}");
}

/// Fortran order, as NumPy may save it, and views that run backwards: rows, hash, limits and parts are the same.
#[test]
fn the_memory_layout_of_arrays_changes_nothing() {
    let columns = (&specs(&["v", "n"])[..], &specs(&["f_n"])[..]);
    let make = |x, y| DataSet::from_values("rows", columns.0, columns.1, x, y).unwrap();
    let x = arr2(&[[0.1, 1.0], [0.2, 2.0], [0.3, 5.0]]);
    let y = arr2(&[[3.0], [4.0], [5.0]]);
    let plain = make(x.clone(), y.clone());
    let fortran = ArrayView::from_shape((3, 2).f(), &[0.1, 0.2, 0.3, 1.0, 2.0, 5.0]).unwrap();
    assert!(!fortran.is_standard_layout());
    let mut backwards = x.select(Axis(0), &[2, 1, 0]);
    backwards.invert_axis(Axis(0));
    assert!(!backwards.is_standard_layout());
    for x in [fortran.to_owned(), backwards] {
        let data = make(x, y.clone());
        assert_eq!(data, plain);
        let (limits, target_limits) = data.scalings(Method::ZScore);
        assert_eq!(limits, plain.scalings(Method::ZScore).0);
        let scaled = |data: &DataSet| data.scaled(&limits, &target_limits);
        assert_eq!(scaled(&data), scaled(&plain));
        assert_eq!(data.subset(&[2, 0]).unwrap(), plain.subset(&[2, 0]).unwrap());
    }
}

#[test]
fn labels_of_arrays_are_one_a_row() {
    let columns = (&specs(&["v"])[..], &specs(&["f_n"])[..]);
    let (x, y) = (arr2(&[[0.1], [0.2]]), arr2(&[[3.0], [4.0]]));
    let data = || DataSet::from_values("rows", columns.0, columns.1, x.clone(), y.clone()).unwrap();
    let texts = |texts: &[&str]| texts.iter().map(|&text| text.to_owned()).collect::<Vec<_>>();
    assert_eq!(data().with_labels(texts(&["a", "b"])).unwrap().labels(), ["a", "b"]);
    let error = data().with_labels(texts(&["a"])).unwrap_err();
    assert_eq!(error.to_string(), "rows: 1 labels for 2 rows");
    let error = data().with_labels(texts(&["a", ""])).unwrap_err();
    assert!(matches!(error, DataSetError::NoLabel { .. }), "{error}");
}
