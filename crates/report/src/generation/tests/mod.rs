//! A process ends at every operation of a generation, and also during the recovery.

pub(super) mod crash;

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use tempfile::TempDir;

use self::crash::ended_after;
use super::manifest::{Difference, MANIFEST, Manifest};
use super::recover;
use crate::{Destination, Folder, OutputError};

type Files = BTreeMap<String, String>;

/// A folder in memory, where there is one, because a sync to disk takes milliseconds.
fn folder() -> TempDir {
    tempfile::tempdir_in("/dev/shm").or_else(|_| tempfile::tempdir()).expect("a folder")
}

/// Returns the files below a folder except the manifests, whose content the files determine.
fn files(root: &Path) -> Files {
    fn walk(folder: &Path, prefix: &str, found: &mut Files) {
        for entry in fs::read_dir(folder).into_iter().flatten() {
            let entry = entry.expect("an entry");
            let name = format!("{prefix}{}", entry.file_name().to_string_lossy());
            if entry.path().is_dir() {
                walk(&entry.path(), &format!("{name}/"), found);
            } else if entry.file_name() != MANIFEST {
                found.insert(name, fs::read_to_string(entry.path()).expect("a file"));
            }
        }
    }
    let mut found = Files::new();
    walk(root, "", &mut found);
    found
}

fn of(list: &[(&str, &str)]) -> Files {
    list.iter().map(|(name, text)| ((*name).to_owned(), (*text).to_owned())).collect()
}

/// Writes files, of which `x/…` are in the folder x, and `a/…` and `b/…` in folders of their own.
fn write(root: &Path, list: &[(&str, &str)]) -> Result<Folder, OutputError> {
    let units: Vec<&str> = list.iter().map(|(name, _)| unit(name).0).collect();
    let folder = Destination::new(root).open("run", &units)?;
    for (name, text) in list {
        let (unit, name) = unit(name);
        let within = if unit.is_empty() { folder.clone() } else { folder.folder(unit) };
        within.write(name, text.as_bytes())?;
    }
    folder.commit()?;
    Ok(folder)
}

fn unit(name: &str) -> (&str, &str) {
    let of_folder = name.split_once('/').filter(|(folder, _)| ["x", "a", "b"].contains(folder));
    of_folder.unwrap_or(("", name))
}

/// Checks all folders against their manifests.
fn verify(root: &Path) {
    for folder in [root.to_owned(), root.join("x"), root.join("a"), root.join("b")] {
        if folder.join(MANIFEST).exists() {
            let manifest = Manifest::read(&folder).expect("intact");
            assert_eq!(manifest.differences(&folder), [], "{}", folder.display());
        }
    }
}

/// An old generation, files of others, a new generation, and true if a plain reader never sees a mixture.
struct Case {
    old: &'static [(&'static str, &'static str)],
    others: &'static [(&'static str, &'static str)],
    new: &'static [(&'static str, &'static str)],
    is_one_step: bool,
}

const OLD: &[(&str, &str)] = &[("x/trace", "old"), ("x/summary", "old"), ("x/left", "old"), ("x/deep/figure", "old")];
const NEW: &[(&str, &str)] = &[("x/trace", "new"), ("x/summary", "new"), ("x/more", "new")];
const CAN_EXCHANGE: bool = cfg!(any(target_os = "linux", target_os = "macos"));

const CASES: [Case; 6] = [
    Case { old: &[], others: &[], new: NEW, is_one_step: true },
    Case { old: &[("x/trace", "old"), ("x/left", "old")], others: &[], new: NEW, is_one_step: CAN_EXCHANGE },
    Case { old: &[("x/trace", "old")], others: &[("x/note", "user")], new: NEW, is_one_step: CAN_EXCHANGE },
    Case { old: OLD, others: &[("x/sub/note", "user")], new: NEW, is_one_step: false },
    Case {
        old: &[("one", "old"), ("two", "old")],
        others: &[("note", "user")],
        new: &[("one", "new")],
        is_one_step: false,
    },
    Case {
        old: &[("one", "old"), ("a/trace", "old"), ("b/trace", "old"), ("b/left", "old")],
        others: &[("a/note", "user"), ("c/trace", "user")],
        new: &[("one", "new"), ("a/trace", "new"), ("b/trace", "new")],
        is_one_step: false,
    },
];

impl Case {
    fn set_up(&self) -> TempDir {
        let root = folder();
        if !self.old.is_empty() {
            write(root.path(), self.old).expect("written");
        }
        for (name, text) in self.others {
            let path = root.path().join(name);
            fs::create_dir_all(path.parent().expect("a folder")).expect("created");
            fs::write(path, text).expect("written");
        }
        root
    }

    /// True if a folder is the old one or the new one, with the files of others.
    fn is_whole(&self, found: &Files) -> bool {
        let is = |list: &[(&'static str, &'static str)]| *found == of(&[list, self.others].concat());
        is(self.old) || is(self.new)
    }

    fn check(&self, root: &Path, at: &str) {
        recover(root).expect("recovered");
        let found = files(root);
        assert!(self.is_whole(&found), "{at}: {found:?}");
        verify(root);
        let leftovers = fs::read_dir(root).expect("a folder").flatten();
        let leftovers = leftovers.filter(|entry| entry.file_name().to_string_lossy().starts_with(".trocar"));
        assert_eq!(leftovers.count(), 0, "{at}");
    }
}

#[test]
fn after_a_crash_at_any_operation_a_folder_is_the_old_one_or_the_new_one() {
    for (number, case) in CASES.iter().enumerate() {
        let mut steps = 0;
        loop {
            let root = case.set_up();
            let (done, is_complete) = ended_after(Some(steps), || drop(write(root.path(), case.new)));
            let at = format!("case {number}, after {done:?}");
            if case.is_one_step {
                let mut seen = files(root.path());
                seen.retain(|name, _| !name.starts_with(".trocar"));
                assert!(case.is_whole(&seen), "{at}: a reader sees {seen:?}");
            }
            case.check(root.path(), &at);
            if is_complete {
                assert!(steps > 10, "{at}");
                break;
            }
            steps += 1;
        }
    }
}

#[test]
fn a_crash_during_the_recovery_changes_nothing() {
    for (number, case) in CASES.iter().enumerate() {
        let root = case.set_up();
        let total = ended_after(None, || drop(write(root.path(), case.new))).0.len();
        // The steps from the journal on.
        for steps in total - 12..total {
            let mut second = 0;
            loop {
                let root = case.set_up();
                let (done, _) = ended_after(Some(steps), || drop(write(root.path(), case.new)));
                let (also, is_complete) = ended_after(Some(second), || drop(recover(root.path())));
                case.check(root.path(), &format!("case {number}, after {done:?} and {also:?}"));
                if is_complete {
                    break;
                }
                second += 1;
            }
        }
    }
}

#[test]
fn everything_is_synced_before_the_journal_decides() {
    let root = CASES[5].set_up();
    let (done, _) = ended_after(None, || drop(write(root.path(), CASES[5].new)));
    let at = |operation: &str| {
        done.iter().position(|one| one == operation).unwrap_or_else(|| panic!("{operation}: {done:?}"))
    };
    let decision = at("rename journal.json");
    for file in ["one", "trace", "manifest.json", "journal.draft", "0", "1", "2"] {
        assert!(at(&format!("sync {file}")) < decision, "{file}: {done:?}");
    }
    let moves = |operation: &String| {
        ["rename one", "exchange a", "exchange b", "rename trace", "remove left"].contains(&operation.as_str())
    };
    assert!(done.iter().position(moves).is_some_and(|first| first > decision), "{done:?}");
    assert!(at("remove journal.json") > done.iter().rposition(moves).unwrap_or(0), "{done:?}");
}

#[test]
fn files_of_others_and_changed_files_stay() {
    let root = folder();
    write(root.path(), &[("x/trace", "old"), ("x/left", "old"), ("x/mine", "old")]).expect("written");
    fs::write(root.path().join("x/mine"), "changed by the user").expect("written");
    fs::write(root.path().join("x/note"), "user").expect("written");
    write(root.path(), &[("x/trace", "new")]).expect("written");
    let kept = [("x/trace", "new"), ("x/mine", "changed by the user"), ("x/note", "user")];
    assert_eq!(files(root.path()), of(&kept));
    // Files of another command stay as well.
    let folder = Destination::new(root.path()).open("stability", &["x"]).expect("opened");
    folder.folder("x").write("poles", b"stability").expect("written");
    folder.commit().expect("stored");
    write(root.path(), &[("x/trace", "newer")]).expect("written");
    let found = files(root.path());
    assert_eq!((&*found["x/poles"], &*found["x/trace"]), ("stability", "newer"));
    verify(root.path());
}

#[test]
fn a_damaged_file_is_written_again_with_the_same_content() {
    let root = folder();
    write(root.path(), NEW).expect("written");
    fs::write(root.path().join("x/trace"), "damaged").expect("written");
    write(root.path(), NEW).expect("written");
    assert_eq!(files(root.path()), of(NEW));
}

#[test]
fn a_second_command_with_the_same_folder_is_refused() {
    let root = folder();
    let first = Destination::new(root.path()).open("run", &["x"]).expect("opened");
    let error = Destination::new(root.path()).open("run", &["", "x"]).expect_err("busy");
    assert!(matches!(&error, OutputError::Busy { path } if path.ends_with("x")), "{error}");
    // A folder is claimed at the latest by its first file.
    let second = Destination::new(root.path()).open("run", &["y"]).expect("opened");
    assert!(matches!(second.folder("x").write("trace", b""), Err(OutputError::Busy { .. })));
    second.folder("y").write("trace", b"second").expect("written");
    second.commit().expect("stored");
    first.folder("x").write("trace", b"first").expect("written");
    first.commit().expect("stored");
    drop((first, second));
    assert_eq!(files(root.path()), of(&[("x/trace", "first"), ("y/trace", "second")]));
    assert!(Destination::new(root.path()).open("run", &["x"]).is_ok());
}

#[test]
fn without_a_commit_nothing_remains() {
    let root = folder();
    let inner = root.path().join("out");
    let folder = Destination::new(&inner).open("run", &["x"]).expect("opened");
    folder.folder("x").write("trace", b"text").expect("written");
    drop(folder);
    assert!(!inner.exists());
}

#[test]
fn a_target_that_cannot_be_written_is_an_error_before_anything_changes() {
    let root = folder();
    write(root.path(), &[("x/trace", "old"), ("x/deep/figure", "old")]).expect("written");
    fs::create_dir_all(root.path().join("x/summary/inner")).expect("created");
    let error = write(root.path(), &[("x/trace", "new"), ("x/summary", "new")]).expect_err("a folder");
    assert!(matches!(&error, OutputError::Write { path, .. } if path.ends_with("x/summary")), "{error}");
    assert_eq!(files(root.path()), of(&[("x/trace", "old"), ("x/deep/figure", "old")]));
    verify(root.path());
}

#[test]
fn a_file_in_place_of_a_folder_is_an_error_before_anything_changes() {
    for (file, path) in [("x", "x"), ("x/deep", "x/deep"), ("a", "a")] {
        let root = folder();
        let at = root.path().join(file);
        fs::create_dir_all(at.parent().expect("a folder")).expect("created");
        fs::write(&at, "user").expect("written");
        let error = write(root.path(), &[("x/deep/figure", "new"), ("a/trace", "new")]).expect_err("a file");
        assert!(matches!(&error, OutputError::Write { path: at, .. } if at.ends_with(path)), "{file}: {error}");
        assert_eq!(files(root.path()), of(&[(file, "user")]));
    }
}

#[test]
fn a_discarded_folder_keeps_its_former_files() {
    let root = folder();
    write(root.path(), &[("a/trace", "old"), ("b/trace", "old")]).expect("written");
    let folder = Destination::new(root.path()).open("run", &["a", "b"]).expect("opened");
    for name in ["a", "b"] {
        folder.folder(name).write("trace", b"new").expect("written");
    }
    folder.folder("b").discard();
    folder.commit().expect("stored");
    drop(folder);
    assert_eq!(files(root.path()), of(&[("a/trace", "new"), ("b/trace", "old")]));
    verify(root.path());
}

#[cfg(unix)]
#[test]
fn a_folder_that_is_a_link_stays_one() {
    let (root, elsewhere) = (folder(), tempfile::tempdir().expect("a folder"));
    std::os::unix::fs::symlink(elsewhere.path(), root.path().join("x")).expect("linked");
    write(root.path(), NEW).expect("written");
    assert!(fs::symlink_metadata(root.path().join("x")).expect("there").is_symlink());
    assert_eq!(files(elsewhere.path()).len(), NEW.len());
    verify(root.path());
}

#[test]
fn every_change_of_a_folder_is_a_difference() {
    let root = folder();
    write(root.path(), &[("one", "text"), ("two", "text"), ("a/trace", "text")]).expect("written");
    let manifest = || Manifest::read(root.path()).expect("intact");
    let path = |name: &str| root.path().join(name);
    fs::remove_file(path("one")).expect("removed");
    fs::write(path("two"), "tex\u{0}").expect("written");
    fs::remove_file(path("a/manifest.json")).expect("removed");
    let found = [
        Difference::Missing("one".into()),
        Difference::Changed("two".into()),
        Difference::Missing("a/manifest.json".into()),
    ];
    assert_eq!(manifest().differences(root.path()), found);
    let text = fs::read(path(MANIFEST)).expect("there");
    for (at, bit) in (0..text.len()).flat_map(|at| [0, 4].map(|bit| (at, bit))) {
        let mut damaged = text.clone();
        damaged[at] ^= 1 << bit;
        fs::write(path(MANIFEST), &damaged).expect("written");
        assert!(Manifest::read(root.path()).is_err(), "bit {bit} of byte {at}");
    }
    for length in [0, 1, text.len() / 2, text.len() - 1] {
        fs::write(path(MANIFEST), &text[..length]).expect("written");
        assert!(Manifest::read(root.path()).is_err(), "{length} bytes");
    }
}
