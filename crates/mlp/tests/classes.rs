//! Classes distinguished: softmax and cross-entropy over more columns than gripd takes.

#[cfg(test)]
mod tests {
    use mlp::train::{
        Algorithm, Classes, ColumnSpec, DataSet, FitConfig, FitError, ModelFile, Precision,
        RunConfig, fit,
    };

    /// Three classes of points in 24 columns, of which two matter.
    fn points(rows: usize, shift: usize) -> DataSet {
        let inputs: Vec<ColumnSpec> = (0..24).map(|at| format!("x{at}").parse().unwrap()).collect();
        let value = |(row, at): (usize, usize)| {
            let turn = (row + shift) as f64 * 2.399;
            let (sin, cos) = turn.sin_cos();
            match at {
                0 => sin,
                1 => cos,
                _ => ((row * 31 + at * 17 + shift) % 101) as f64 / 101.0,
            }
        };
        let values = ndarray::Array2::from_shape_fn((rows, 24), value);
        let class = |row: ndarray::ArrayView1<'_, f64>| {
            let name = if row[0] > 0.5 {
                "up"
            } else if row[1] > 0.0 {
                "right"
            } else {
                "left"
            };
            name.to_owned()
        };
        let texts: Vec<String> = values.rows().into_iter().map(class).collect();
        let classes = Classes { column: "side".to_owned(), names: Vec::new() };
        DataSet::from_classes("points", &inputs, values, &classes, &texts).unwrap()
    }

    #[test]
    fn classes_of_many_columns_are_learned_in_both_precisions() {
        let (train, test) = (points(300, 0), points(200, 1000));
        let names: Vec<&str> = train.targets.iter().map(|class| class.name.as_str()).collect();
        assert_eq!(names, ["left", "right", "up"]);
        for precision in [Precision::Single, Precision::Double] {
            for algorithm in ["rprop", "scg", "lbfgs"] {
                let config = FitConfig {
                    algorithm: algorithm.parse().unwrap(),
                    run: RunConfig { epochs: 150, ..RunConfig::default() },
                    precision,
                    ..FitConfig::default()
                };
                let fit = fit(&train, None, Some(&test), &config).unwrap();
                let (trained, tested) = (fit.train.classes.unwrap(), fit.test.unwrap());
                assert!(trained.accuracy > 0.97, "{algorithm} {precision:?}: {trained:?}");
                assert!(
                    trained.cross_entropy < 0.2 && (0.0..0.1).contains(&tested.mse),
                    "{trained:?}"
                );
                assert!(
                    tested.classes.unwrap().accuracy > 0.85,
                    "{algorithm}: {:?}",
                    tested.classes
                );
                let reported = fit.runs[0].mse;
                assert!((reported - trained.cross_entropy).abs() < 1e-4, "{reported} {trained:?}");
                let text = fit.file.to_json().unwrap();
                assert_eq!(ModelFile::from_json(&text).unwrap().classes.as_deref(), Some("side"));
            }
        }
        let config =
            FitConfig { algorithm: Algorithm::Lm(Default::default()), ..FitConfig::default() };
        let error = fit(&train, None, None, &config).unwrap_err();
        assert_eq!(error, FitError::Squares { algorithm: "lm" });
    }

    #[test]
    fn classes_of_a_file_are_named_where_they_are_wrong() {
        let inputs: [ColumnSpec; 1] = ["x".parse().unwrap()];
        let read = |csv: &str, names: &[&str]| {
            let names = names.iter().map(|name| (*name).to_owned()).collect();
            let classes = Classes { column: "c".to_owned(), names };
            DataSet::from_class_csv("r.csv", csv.as_bytes(), &inputs, &classes, Some("g"))
        };
        let rows = read("g,x,c\np,1,b\nq,2,a\n", &[]).unwrap();
        assert_eq!(
            (rows.target_values().row(0).to_vec(), rows.labels()),
            (vec![0.0, 1.0], &["p".to_owned(), "q".to_owned()][..])
        );
        assert_eq!(
            rows.scaled(&rows.input_scalings(), &rows.target_scalings())[1],
            rows.target_values()
        );
        let message = |csv: &str, names: &[&str]| read(csv, names).unwrap_err().to_string();
        assert_eq!(
            message("g,x,c\np,1,b\nq,2,z\n", &["a", "b"]),
            "r.csv, row 2: \"z\" is none of the classes a, b"
        );
        assert_eq!(
            message("g,x,c\np,1,b\n", &[]),
            "1 classes in column \"c\": 2 to 64 are possible"
        );
        assert!(message("g,x,c\np,1,\n", &[]).contains("line 2, column \"c\""));
    }
}
