//! Embedded files, which the program finds from any directory.

use super::keys::nearest_of;

pub const PREFIX: &str = "builtin:";

const ENDING: &str = ".toml";

/// Pairs of full name and content.
macro_rules! embedded {
    (scenarios: $($scenario:literal)*; recordings: $($recording:literal)*) => {
        &[
            $((concat!($scenario, ".toml"), include_bytes!(concat!("../scenarios/", $scenario, ".toml"))),)*
            $(($recording, include_bytes!(concat!("../scenarios/recordings/", $recording))),)*
        ]
    };
}

const FILES: &[(&str, &[u8])] = embedded! {
    scenarios:
        "paper/classical" "paper/augmented" "paper/amplified" "paper/depth-classical" "paper/depth-augmented" "paper/depth-swing"
        "paper/real-classical" "paper/real-augmented"
        "layers/through-the-skin" "layers/skin-augmented" "layers/direct-access" "layers/epidural"
        "hand/fast-stab" "hand/trembling-hand" "hand/firm-grip" "hand/relaxed-grip" "hand/reflex" "hand/reflex-augmented"
        "hand/perceiving" "hand/stretch-reflexes"
        "link/lossy-link" "link/saturating-master" "link/long-delay" "link/outage-at-the-rupture" "link/local-force"
        "link/position-position" "link/four-channel"
        "passivity/late-wall" "passivity/late-wall-time-domain" "passivity/late-wall-waves" "passivity/late-wall-tank"
        "passivity/long-delay-time-domain" "passivity/long-delay-waves" "passivity/long-delay-tank"
        "sensing/wrong-detector-settings" "sensing/sensor-not-ideal"
        "strategies/clutch" "strategies/snap" "strategies/ramp-until-load" "strategies/speed-limit"
        "strategies/forbidden-region" "strategies/damping" "strategies/cue" "strategies/tip-force"
        "strategies/fade" "strategies/when-still" "strategies/fixture" "strategies/designed"
        "rig/teleop-1dof-c" "rig/teleop-1dof-f"
        "tearing/yellow-ligament" "tearing/firm-phantom";
    recordings: "in_vivo_like.csv" "own_ctrl_pop.csv"
};

/// Pairs of full name and content.
const SWEEPS: &[(&str, &[u8])] = embedded! {
    scenarios: "sweeps/patients" "sweeps/scale_factors" "sweeps/small" "sweeps/million";
    recordings:
};

fn files() -> impl Iterator<Item = &'static (&'static str, &'static [u8])> {
    FILES.iter().chain(SWEEPS)
}

pub fn sweeps() -> impl Iterator<Item = &'static str> {
    SWEEPS.iter().map(|(file, _)| *file)
}

/// The shipped scenarios by full name, folder by folder.
pub fn questions() -> impl Iterator<Item = (&'static str, &'static str)> {
    let scenarios = FILES.iter().filter(|(file, _)| file.ends_with(ENDING));
    scenarios.map(|(file, content)| {
        let first = content.split(|&byte| byte == b'\n').next().unwrap_or_default();
        (*file, std::str::from_utf8(first).unwrap_or_default().trim_start_matches(['#', ' ']))
    })
}

pub fn recordings() -> impl Iterator<Item = &'static str> {
    FILES.iter().map(|(file, _)| *file).filter(|file| !file.ends_with(ENDING))
}

/// Accepts the names that [`find`] accepts.
pub fn content(name: &str) -> Option<&'static [u8]> {
    let file = find(name)?;
    files().find(|(known, _)| *known == file).map(|(_, content)| *content)
}

/// A scenario or sweep file is also found without its ending or folder.
pub fn find(name: &str) -> Option<&'static str> {
    let wanted = without_ending(name);
    let is_wanted = |file: &str| {
        file == name || file.strip_suffix(ENDING).is_some_and(|full| full == wanted || last_part(full) == wanted)
    };
    files().map(|(file, _)| *file).find(|file| is_wanted(file))
}

/// Without its ending; `None` if none is similar enough.
pub fn nearest(name: &str) -> Option<&'static str> {
    let name = without_ending(name);
    let last = last_part(name);
    let known = || questions().map(|(file, _)| without_ending(file));
    let found = find(last).or_else(|| nearest_of(last, known().map(last_part)).and_then(find));
    found.map(without_ending).or_else(|| nearest_of(name, known()))
}

fn last_part(name: &str) -> &str {
    name.rsplit_once('/').map_or(name, |(_, last)| last)
}

fn without_ending(name: &str) -> &str {
    name.strip_suffix(ENDING).unwrap_or(name)
}

#[cfg(test)]
mod tests {
    use std::collections::HashSet;
    use std::path::Path;

    use super::super::{Scenario, Source};
    use super::*;

    #[test]
    fn every_scenario_of_the_folders_is_embedded_and_begins_with_a_question() {
        let root = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/scenarios"));
        let entries = |folder: &Path| -> Vec<_> {
            std::fs::read_dir(folder).expect("a folder").map(|entry| entry.expect("an entry").path()).collect()
        };
        let folders = entries(root).into_iter().filter(|path| path.is_dir());
        let on_disk: HashSet<_> = folders
            .flat_map(|folder| entries(&folder))
            .filter(|path| path.extension().is_some_and(|ending| ending == "toml"))
            .map(|path| path.strip_prefix(root).expect("within").to_string_lossy().into_owned())
            .collect();
        assert_eq!(on_disk, questions().map(|(name, _)| name).chain(sweeps()).map(str::to_owned).collect());
        assert!(entries(root).iter().all(|path| path.extension().is_none_or(|ending| ending != "toml")));
        for (name, question) in questions() {
            assert!(question.contains('?'), "{name}: {question}");
        }
    }

    #[test]
    fn a_scenario_has_the_name_of_its_file_and_is_found_by_every_form() {
        for (file, _) in questions() {
            let (full, last) = (without_ending(file), last_part(without_ending(file)));
            let scenario = Scenario::load(&Source::parse(&format!("{PREFIX}{file}")), &[]).expect("good");
            assert_eq!(scenario.name, last);
            for form in [file, full, last, &format!("{last}.toml")] {
                assert_eq!(find(form), Some(file), "{form}");
            }
        }
        for file in recordings().chain(sweeps()) {
            assert_eq!(find(file), Some(file));
        }
        assert_eq!(find("sweeps/patients"), Some("sweeps/patients.toml"));
    }

    #[test]
    fn a_misspelt_name_finds_its_neighbour() {
        assert_eq!(nearest("layers/skin-augmentd.toml"), Some("layers/skin-augmented"));
        assert_eq!(nearest("/somewhere/epidurals"), Some("layers/epidural"));
        assert_eq!(nearest("skin_augmented"), Some("layers/skin-augmented"));
        assert_eq!(nearest("mine.toml"), None);
    }
}
