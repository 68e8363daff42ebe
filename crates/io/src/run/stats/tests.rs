use super::*;

fn row(frame: u64, body: &str) -> Row {
    Row {
        frame,
        time: frame as f64 / 30.0,
        body: body.to_owned(),
        ms_step: 1.5,
        ms_volume: 0.25,
        ms_embed: 0.125,
        ms_write: 2.0,
        volume_rest: 1.0,
        volume_before: 1.25,
        volume_after: 1.0,
        lambda: -0.01,
        residual: 1e-9,
        capped: false,
        energy_kinetic: 3.0,
        max_speed: 0.5,
    }
}

fn text_of(path: &Path) -> String {
    std::fs::read_to_string(path).unwrap()
}

#[test]
fn file_is_valid_after_every_frame() {
    let directory = tempfile::tempdir().unwrap();
    for name in ["stats.csv", "stats.json"] {
        let path = directory.path().join(name);
        let mut stats = Stats::create(&path).unwrap();
        for frame in 0..3 {
            stats.append_rows(&[row(frame, "a"), row(frame, "b")]).unwrap();
            let text = text_of(&path);
            assert_eq!(text.matches("1.25").count(), 2 * (frame as usize + 1));
            assert!(text.ends_with(if name == "stats.csv" { ",0.5\n" } else { "0.5}\n]\n" }));
        }
        let columns = 15;
        if name == "stats.csv" {
            assert!(text_of(&path).lines().all(|line| line.split(',').count() == columns));
        } else {
            assert_eq!(text_of(&path).matches("\":").count(), 6 * columns);
        }
    }
}

#[test]
fn resume_continues_after_the_last_frame_kept() {
    let directory = tempfile::tempdir().unwrap();
    for name in ["stats.csv", "stats.json"] {
        let path = directory.path().join(name);
        let mut whole = Stats::create(&path).unwrap();
        (0..5).for_each(|frame| whole.append_rows(&[row(frame, "a"), row(frame, "b")]).unwrap());
        let expected = text_of(&path);
        for kept in 0..5 {
            for removed in [0, 1, 40] {
                // A run that is killed during a write leaves part of a line of a later frame.
                let text = if kept < 3 { &expected[..expected.len() - removed] } else { &expected };
                std::fs::write(&path, text).unwrap();
                let mut resumed = Stats::resume(&path, kept).unwrap();
                for frame in kept + 1..5 {
                    resumed.append_rows(&[row(frame, "a"), row(frame, "b")]).unwrap();
                }
                assert_eq!(text_of(&path), expected, "{name}, frame {kept}, {removed} bytes removed");
            }
        }
    }
}

#[test]
fn files_that_are_not_statistics_are_rejected_and_unchanged() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("notes.csv");
    std::fs::write(&path, "my notes\n").unwrap();
    assert!(matches!(Stats::resume(&path, 3), Err(RunError::NotStats { .. })));
    assert_eq!(text_of(&path), "my notes\n");
    assert!(matches!(Stats::create(&directory.path().join("stats.txt")), Err(RunError::StatsName { .. })));
}

#[test]
fn json_writes_nan_as_null() {
    let text = Kind::Json.rows(&[Row { lambda: f64::NAN, ..row(0, "a") }], true).unwrap();
    assert!(String::from_utf8(text).unwrap().contains("\"lambda\":null"));
}

#[test]
fn csv_columns_match_the_manual() {
    let columns = "frame,time,body,ms_step,ms_volume,ms_embed,ms_write,volume_rest,volume_before,volume_after,\
                   lambda,residual,capped,energy_kinetic,max_speed\n";
    assert_eq!(Kind::Csv.head().unwrap(), columns.as_bytes());
}
