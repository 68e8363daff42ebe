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
        contacts: 3,
        overlap: 0.75,
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
            assert!(text.ends_with(if name == "stats.csv" { ",0.75\n" } else { "0.75}\n]\n" }));
        }
        let columns = 17;
        if name == "stats.csv" {
            assert!(text_of(&path).lines().all(|line| line.split(',').count() == columns));
        } else {
            assert_eq!(text_of(&path).matches("\":").count(), 6 * columns);
        }
    }
}

#[test]
fn resume_continues_after_the_rows_of_the_record() {
    let directory = tempfile::tempdir().unwrap();
    for name in ["stats.csv", "stats.json"] {
        let path = directory.path().join(name);
        let mut whole = Stats::create(&path).unwrap();
        let mut records = vec![whole.record()];
        for frame in 0..5 {
            whole.append_rows(&[row(frame, "a"), row(frame, "b")]).unwrap();
            records.push(whole.record());
        }
        let expected = text_of(&path);
        for (kept, record) in (0..).zip(&records) {
            for removed in [0, 1, 40] {
                // A run that is killed during a write leaves part of a line of a later frame.
                let text = if kept < 4 { &expected[..expected.len() - removed] } else { &expected };
                std::fs::write(&path, text).unwrap();
                let rows = read_rows(&path, record, (0, kept)).unwrap();
                let mut resumed = Stats::resume(&path, rows).unwrap();
                for frame in kept..5 {
                    resumed.append_rows(&[row(frame, "a"), row(frame, "b")]).unwrap();
                }
                assert_eq!(text_of(&path), expected, "{name}, {kept} frames, {removed} bytes removed");
                assert_eq!(resumed.record(), records[5]);
            }
        }
    }
}

#[test]
fn files_without_the_recorded_rows_are_rejected_and_unchanged() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("notes.csv");
    let mut stats = Stats::create(&path).unwrap();
    stats.append_rows(&[row(0, "a")]).unwrap();
    let record = stats.record();
    for text in ["my notes\n".to_owned(), text_of(&path).replace("1.25", "1.26"), "x".repeat(1000)] {
        std::fs::write(&path, &text).unwrap();
        assert!(matches!(read_rows(&path, &record, (0, 0)), Err(RunError::StatsLost { .. })));
        assert_eq!(text_of(&path), text);
    }
    std::fs::remove_file(&path).unwrap();
    assert!(matches!(read_rows(&path, &record, (0, 0)), Err(RunError::StatsLost { .. })));
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
                   lambda,residual,capped,energy_kinetic,max_speed,contacts,overlap\n";
    assert_eq!(Kind::Csv.head().unwrap(), columns.as_bytes());
}
