//! The scenarios and recordings embedded in the binary, so that it works from any directory.

/// The prefix of a path to an embedded file.
pub const PREFIX: &str = "builtin:";

const FILES: &[(&str, &[u8])] = &[
    ("classical.toml", include_bytes!("../../scenarios/classical.toml")),
    ("augmented.toml", include_bytes!("../../scenarios/augmented.toml")),
    ("depth_classical.toml", include_bytes!("../../scenarios/depth_classical.toml")),
    ("depth_augmented.toml", include_bytes!("../../scenarios/depth_augmented.toml")),
    ("real_classical.toml", include_bytes!("../../scenarios/real_classical.toml")),
    ("real_augmented.toml", include_bytes!("../../scenarios/real_augmented.toml")),
    ("01_augmented.toml", include_bytes!("../../scenarios/01_augmented.toml")),
    ("01_through_the_skin.toml", include_bytes!("../../scenarios/01_through_the_skin.toml")),
    ("02_direct_access.toml", include_bytes!("../../scenarios/02_direct_access.toml")),
    ("03_epidural.toml", include_bytes!("../../scenarios/03_epidural.toml")),
    ("04_fast_stab.toml", include_bytes!("../../scenarios/04_fast_stab.toml")),
    ("05_trembling_hand.toml", include_bytes!("../../scenarios/05_trembling_hand.toml")),
    ("06_firm_grip.toml", include_bytes!("../../scenarios/06_firm_grip.toml")),
    ("07_relaxed_grip.toml", include_bytes!("../../scenarios/07_relaxed_grip.toml")),
    ("08_wrong_detector_settings.toml", include_bytes!("../../scenarios/08_wrong_detector_settings.toml")),
    ("09_clutch.toml", include_bytes!("../../scenarios/09_clutch.toml")),
    ("09_ramp.toml", include_bytes!("../../scenarios/09_ramp.toml")),
    ("09_snap.toml", include_bytes!("../../scenarios/09_snap.toml")),
    ("10_reflex.toml", include_bytes!("../../scenarios/10_reflex.toml")),
    ("10_reflex_augmented.toml", include_bytes!("../../scenarios/10_reflex_augmented.toml")),
    ("12_sensor_not_ideal.toml", include_bytes!("../../scenarios/12_sensor_not_ideal.toml")),
    ("13_replay_by_depth.toml", include_bytes!("../../scenarios/13_replay_by_depth.toml")),
    ("13_replay_by_time.toml", include_bytes!("../../scenarios/13_replay_by_time.toml")),
    ("14_lossy_link.toml", include_bytes!("../../scenarios/14_lossy_link.toml")),
    ("15_saturating_master.toml", include_bytes!("../../scenarios/15_saturating_master.toml")),
    ("16_long_delay.toml", include_bytes!("../../scenarios/16_long_delay.toml")),
    ("16_long_delay_tank.toml", include_bytes!("../../scenarios/16_long_delay_tank.toml")),
    ("16_long_delay_time_domain.toml", include_bytes!("../../scenarios/16_long_delay_time_domain.toml")),
    ("16_long_delay_waves.toml", include_bytes!("../../scenarios/16_long_delay_waves.toml")),
    ("17_outage_at_the_rupture.toml", include_bytes!("../../scenarios/17_outage_at_the_rupture.toml")),
    ("18_local_force.toml", include_bytes!("../../scenarios/18_local_force.toml")),
    ("19_position_position.toml", include_bytes!("../../scenarios/19_position_position.toml")),
    ("20_four_channel.toml", include_bytes!("../../scenarios/20_four_channel.toml")),
    ("21_late_wall.toml", include_bytes!("../../scenarios/21_late_wall.toml")),
    ("22_late_wall_time_domain.toml", include_bytes!("../../scenarios/22_late_wall_time_domain.toml")),
    ("23_late_wall_waves.toml", include_bytes!("../../scenarios/23_late_wall_waves.toml")),
    ("24_late_wall_tank.toml", include_bytes!("../../scenarios/24_late_wall_tank.toml")),
    ("in_vivo_like.csv", include_bytes!("../../scenarios/recordings/in_vivo_like.csv")),
    ("own_ctrl_pop.csv", include_bytes!("../../scenarios/recordings/own_ctrl_pop.csv")),
];

/// The content of an embedded file, by its name without [`PREFIX`].
#[must_use]
pub fn content(name: &str) -> Option<&'static [u8]> {
    FILES.iter().find(|(known, _)| *known == name).map(|(_, content)| *content)
}

/// The names of all embedded files.
pub fn names() -> impl Iterator<Item = &'static str> {
    FILES.iter().map(|(name, _)| *name)
}

/// The embedded scenarios, each with the question in its first line.
pub fn questions() -> impl Iterator<Item = (&'static str, &'static str)> {
    let scenarios = FILES.iter().filter(|(name, _)| name.ends_with(".toml"));
    scenarios.map(|(name, content)| {
        let first = content.split(|&byte| byte == b'\n').next().unwrap_or_default();
        (*name, std::str::from_utf8(first).unwrap_or_default().trim_start_matches(['#', ' ']))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_scenario_of_the_folder_is_embedded_and_begins_with_a_question() {
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/scenarios");
        let files = std::fs::read_dir(folder).expect("a folder").map(|entry| entry.expect("an entry").file_name());
        let mut on_disk: Vec<String> = files.filter_map(|name| name.into_string().ok()).collect();
        on_disk.retain(|name| name.ends_with(".toml"));
        on_disk.sort();
        let mut embedded: Vec<String> = questions().map(|(name, _)| name.to_owned()).collect();
        embedded.sort();
        assert_eq!(on_disk, embedded);
        for (name, question) in questions() {
            assert!(question.contains('?'), "{name}: {question}");
        }
    }
}
