//! The search for files, in folders as they are.

use grip_session::config::Layers;
use std::fs;

#[test]
fn the_files_of_the_user_are_found_and_a_missing_one_is_not_missed() {
    let home = tempfile::tempdir().unwrap();
    let folder = home.path().join("gripd");
    let nothing = Layers::search(Some(home.path())).unwrap();
    assert!(!nothing.files().any(|file| file.starts_with(home.path())));
    fs::create_dir(&folder).unwrap();
    fs::write(folder.join("gripd.toml"), "baud = 115200\n").unwrap();
    let found = Layers::search(Some(home.path())).unwrap();
    assert!(found.files().any(|file| file == folder.join("gripd.toml")));
    assert_eq!(found.resolve().unwrap().baud, Some(115_200));
}

#[test]
fn a_file_that_is_there_and_cannot_be_read_is_reported() {
    let home = tempfile::tempdir().unwrap();
    let file = home.path().join("gripd/gripd.toml");
    fs::create_dir_all(&file).unwrap();
    let error = Layers::search(Some(home.path())).unwrap_err().to_string();
    assert!(error.contains("gripd.toml: the configuration cannot be read: "), "{error}");
}
