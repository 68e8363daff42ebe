//! Defines the settings that a run must keep when it resumes.

use serde::{Deserialize, Serialize};

use super::fingerprint;

/// Settings of a run. If one of them differs, the frames of two runs do not belong together.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct Settings {
    /// Version of the program.
    pub(super) version: String,
    /// Fingerprint of the scene.
    pub(super) fingerprint: String,
    /// Names of the formats of the frames.
    pub(super) format: String,
    /// Axes, scale and rate of the files, for each key of `[output]` its value.
    pub(super) files: Vec<(String, String)>,
    /// Number of frame 0 in file names.
    pub(super) start_frame: u32,
    /// Interval between written frames, in frames.
    pub(super) every: u32,
    /// Absolute path of the statistics file, for messages; `None` without statistics. Runs with different
    /// paths can belong together, because the file can be moved.
    pub(super) stats: Option<String>,
}

impl Settings {
    /// Describes the first difference from the settings `now` in a message for the user. Returns `None` if
    /// the runs belong together.
    pub(super) fn difference(&self, now: &Self) -> Option<String> {
        if self.version != now.version {
            return Some(format!(
                "version {} of supple wrote it, and this is version {}",
                self.version, now.version
            ));
        }
        if let Some(difference) = fingerprint::difference(&self.fingerprint, &now.fingerprint) {
            return Some(difference);
        }
        if self.format != now.format {
            return Some(format!("the format changed from {} to {}", self.format, now.format));
        }
        for ((key, before), (_, now)) in self.files.iter().zip(&now.files) {
            if before != now {
                return Some(format!("`{key}` of the files changed from {before} to {now}"));
            }
        }
        if self.start_frame != now.start_frame {
            return Some(format!(
                "the number of the first frame changed from {} to {}",
                self.start_frame, now.start_frame
            ));
        }
        if self.every != now.every {
            return Some(format!(
                "the interval between written frames (`every`) changed from {} to {}",
                self.every, now.every
            ));
        }
        match (&self.stats, &now.stats) {
            (Some(before), None) => {
                Some(format!("the earlier run wrote statistics to {before}, and this run writes none"))
            }
            (None, Some(now)) => {
                Some(format!("the earlier run wrote no statistics, and this run writes them to {now}"))
            }
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_difference_is_named() {
        let settings = Settings {
            version: "1.0.0".into(),
            fingerprint: "[simulation]\nfps = 30.0\n".into(),
            format: "obj".into(),
            files: vec![("output.scale".into(), "1".into())],
            start_frame: 0,
            every: 1,
            stats: Some("/a/s.csv".into()),
        };
        let moved = Settings { stats: Some("/b/s.csv".into()), ..settings.clone() };
        assert_eq!(settings.difference(&moved), None);
        for (changed, words) in [
            (Settings { version: "1.0.1".into(), ..settings.clone() }, "version 1.0.0 of supple"),
            (Settings { fingerprint: "[simulation]\nfps = 25.0\n".into(), ..settings.clone() }, "fps = 25.0"),
            (Settings { format: "ply".into(), ..settings.clone() }, "from obj to ply"),
            (
                Settings { files: vec![("output.scale".into(), "100".into())], ..settings.clone() },
                "`output.scale` of the files changed from 1 to 100",
            ),
            (Settings { start_frame: 7, ..settings.clone() }, "from 0 to 7"),
            (Settings { every: 2, ..settings.clone() }, "from 1 to 2"),
            (
                Settings { stats: None, ..settings.clone() },
                "statistics to /a/s.csv, and this run writes none",
            ),
        ] {
            let difference = settings.difference(&changed).unwrap();
            assert!(difference.contains(words), "{difference}");
        }
        let without = Settings { stats: None, ..settings.clone() };
        assert!(without.difference(&settings).unwrap().contains("wrote no statistics"));
    }
}
