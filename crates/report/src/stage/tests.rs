use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use tempfile::TempDir;

use super::{LOCK, NEW, OLD, move_aside};
use crate::manifest::MANIFEST;
use crate::{Destination, Folder, OutputError};

type List = &'static [(&'static str, &'static str)];

fn folder() -> TempDir {
    tempfile::tempdir().expect("a folder")
}

/// Returns the files below a folder, except manifests.
fn files(root: &Path) -> BTreeMap<String, String> {
    let mut found = BTreeMap::new();
    for entry in fs::read_dir(root).into_iter().flatten() {
        let path = entry.expect("an entry").path();
        let name = path.file_name().expect("a name").to_string_lossy().into_owned();
        if path.is_dir() {
            found.extend(files(&path).into_iter().map(|(inner, text)| (format!("{name}/{inner}"), text)));
        } else if name != MANIFEST {
            found.insert(name, fs::read_to_string(&path).expect("text"));
        }
    }
    found
}

fn of(list: List) -> BTreeMap<String, String> {
    list.iter().map(|(name, text)| ((*name).to_owned(), (*text).to_owned())).collect()
}

fn put(root: &Path, list: List) {
    for (name, text) in list {
        let path = root.join(name);
        fs::create_dir_all(path.parent().expect("a folder")).expect("created");
        fs::write(path, text).expect("written");
    }
}

fn staged(root: &Path, command: &'static str, list: List) -> Result<Folder, OutputError> {
    let folder = Destination::new(root).open(command, "x")?;
    list.iter().try_for_each(|(name, text)| folder.write(name, text.as_bytes()))?;
    Ok(folder)
}

fn write(root: &Path, command: &'static str, list: List) -> Result<(), OutputError> {
    staged(root, command, list)?.commit()
}

#[test]
fn a_command_replaces_its_own_files_and_keeps_those_of_others() {
    let cases: [(List, List, List, List); 5] = [
        (&[], &[], &[("a", "new"), ("b/c", "new")], &[("a", "new"), ("b/c", "new")]),
        (&[("a", "old"), ("left", "old"), ("b/left", "old")], &[], &[("a", "new")], &[("a", "new")]),
        (&[("a", "old")], &[("note", "user"), ("a", "changed")], &[("a", "new")], &[("a", "new"), ("note", "user")]),
        (
            &[("b/c", "old"), ("b/left", "old")],
            &[("b/note", "user"), ("b/d/note", "user")],
            &[("b/c", "new")],
            &[("b/c", "new"), ("b/d/note", "user"), ("b/note", "user")],
        ),
        (&[], &[("a", "user"), ("note", "user")], &[("a", "new")], &[("a", "new"), ("note", "user")]),
    ];
    for (old, others, new, expected) in cases {
        let root = folder();
        if !old.is_empty() {
            write(root.path(), "run", old).expect("written");
        }
        put(&root.path().join("x"), others);
        write(root.path(), "run", new).expect("written");
        assert_eq!(files(&root.path().join("x")), of(expected), "{old:?}, {others:?}");
        // Another command keeps them, and its own files stay.
        write(root.path(), "stability", &[("poles", "other")]).expect("written");
        write(root.path(), "run", new).expect("written");
        let mut both = of(expected);
        both.insert("poles".into(), "other".into());
        assert_eq!(files(&root.path().join("x")), both, "{old:?}, {others:?}");
        assert_eq!(fs::read_dir(root.path()).expect("a folder").count(), 1, "leftovers");
    }
}

#[test]
fn a_file_in_place_of_a_folder_or_the_other_way_round_is_an_error_before_anything_changes() {
    let cases: [(List, List, &str); 3] = [
        (&[("x", "user")], &[("a", "new")], "x: "),
        (&[("x/a/note", "user")], &[("a", "new")], "x/a/note: "),
        (&[("x/a", "user")], &[("a/b", "new")], "x/a: "),
    ];
    for (there, new, place) in cases {
        let root = folder();
        put(root.path(), there);
        let error = write(root.path(), "run", new).expect_err("in the way").to_string();
        assert!(error.contains(place) && error.contains("choose another folder"), "{error}");
        assert_eq!(files(root.path()), of(there), "{error}");
    }
}

#[test]
fn without_a_commit_nothing_remains() {
    let root = folder();
    let out = root.path().join("out");
    drop(staged(&out, "run", &[("a", "new")]).expect("staged"));
    assert!(!out.exists());
}

#[test]
fn the_last_of_two_commands_at_once_has_the_folder() {
    let root = folder();
    let first = staged(root.path(), "run", &[("a", "first"), ("left", "first")]).expect("staged");
    write(root.path(), "run", &[("a", "second"), ("more", "second")]).expect("written");
    first.commit().expect("written");
    assert_eq!(files(root.path()), of(&[("x/a", "first"), ("x/left", "first")]));
}

#[test]
fn the_next_command_cleans_up_after_killed_ones_alone() {
    let root = folder();
    put(root.path(), &[("x/a", "old"), ("y/a", "new"), (".trocar-1-notes", "user"), (".trocarrc", "user")]);
    let stage = |name: &str| root.path().join(name);
    put(&stage(".trocar-1-staged"), &[(LOCK, "x"), ("new/a", "new")]);
    put(&stage(".trocar-1-moving"), &[(LOCK, "z"), ("new/a", "new"), ("old/a", "old")]);
    put(&stage(".trocar-1-placed"), &[(LOCK, "y"), ("old/a", "old")]);
    put(&stage(".trocar-1-atwork"), &[(LOCK, "y"), ("new/a", "at work")]);
    fs::create_dir(stage(".trocar-1-begins")).expect("created");
    let lock = fs::File::open(stage(".trocar-1-atwork").join(LOCK)).expect("there");
    lock.try_lock().expect("locked");
    drop(staged(root.path(), "run", &[]).expect("staged"));
    let left: List = &[
        (".trocar-1-atwork/lock", "y"),
        (".trocar-1-atwork/new/a", "at work"),
        (".trocar-1-notes", "user"),
        (".trocarrc", "user"),
        ("x/a", "old"),
        ("y/a", "new"),
        ("z/a", "old"),
    ];
    assert_eq!(files(root.path()), of(left));
    assert_eq!(fs::read_dir(root.path()).expect("a folder").count(), 6);
}

#[test]
fn where_folders_cannot_be_exchanged_the_old_one_is_moved_aside() {
    let root = folder();
    let at = |name: &str| root.path().join(name);
    put(root.path(), &[("new/a", "new"), ("x/a", "old")]);
    move_aside(&at(NEW), &at(OLD), &at("x")).expect("moved");
    assert_eq!(files(root.path()), of(&[("old/a", "old"), ("x/a", "new")]));
    assert!(move_aside(&at(NEW), &at("aside"), &at("x")).is_err(), "there is no new folder");
    assert_eq!(files(&at("x")), of(&[("a", "new")]));
}

#[cfg(unix)]
#[test]
fn a_folder_that_is_a_link_stays_one() {
    let (root, elsewhere) = (folder(), folder());
    fs::create_dir(elsewhere.path().join("there")).expect("created");
    std::os::unix::fs::symlink(elsewhere.path().join("there"), root.path().join("x")).expect("linked");
    write(root.path(), "run", &[("a", "new")]).expect("written");
    assert!(root.path().join("x").is_symlink());
    assert_eq!(files(elsewhere.path()), of(&[("there/a", "new")]));
}
