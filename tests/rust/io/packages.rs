//! USDZ packages: the layout of their files, their stage and images, and stopped and killed runs.

use std::fs;
use std::path::Path;
use std::time::Duration;

use supple_io::run::{Job, Outcome};
use supple_io::scene::Scene;

use crate::run_files::{BLOCK, CopyAfter, StopAfter, written};

const SCENE: &str = r#"
[simulation]
frames = 8
fps = 24
substeps = 2

[output]
format = "usdz"

[[body]]
name = "soft"
mesh = "block.obj"
lattice_vertices = 60
spin = [0, 1, 0]
"#;

const PNG: &[u8] = b"\x89PNG\r\n\x1a\n and some pixels";
const JPEG: &[u8] = b"\xff\xd8\xff\xe0 and some pixels";

fn job(folder: &Path, out: &str, overrides: &[&str]) -> Job {
    let overrides: Vec<String> = overrides.iter().map(ToString::to_string).collect();
    Job::new(Scene::parse(SCENE, "scene.toml", folder, &overrides).unwrap(), folder.join(out))
}

/// Returns the names and the bytes of the files of an archive, by the description of its format: from the list at its end,
/// compared with the header before each file.
pub(crate) fn files(archive: &[u8]) -> Vec<(String, &[u8])> {
    let word = |at: usize| u16::from_le_bytes([archive[at], archive[at + 1]]) as usize;
    let long = |at: usize| word(at) | word(at + 2) << 16;
    let end = archive.len() - 22;
    assert_eq!(&archive[end..end + 4], b"PK\x05\x06");
    let (count, size, mut at) = (word(end + 10), long(end + 12), long(end + 16));
    assert_eq!(at + size, end);
    let mut files = Vec::new();
    for _ in 0..count {
        assert_eq!(&archive[at..at + 4], b"PK\x01\x02");
        let (name, local) = (&archive[at + 46..at + 46 + word(at + 28)], long(at + 42));
        assert_eq!(&archive[local..local + 4], b"PK\x03\x04");
        // Version, flags, method, time, sum and sizes.
        assert_eq!(archive[at + 6..at + 28], archive[local + 4..local + 26]);
        assert_eq!((word(local + 6), word(local + 8)), (0, 0), "no flags, no compression");
        assert_eq!(&archive[local + 30..local + 30 + name.len()], name);
        let start = local + 30 + word(local + 26) + word(local + 28);
        assert_eq!(start % 64, 0);
        let bytes = &archive[start..start + long(local + 22)];
        assert_eq!(long(local + 18), bytes.len());
        assert_eq!(long(local + 14) as u32, crc32(bytes));
        files.push((String::from_utf8(name.to_vec()).unwrap(), bytes));
        at += 46 + name.len() + word(at + 30) + word(at + 32);
    }
    files
}

/// CRC-32 bit by bit.
fn crc32(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(!0_u32, |crc, byte| {
        (0..8).fold(crc ^ u32::from(*byte), |crc, _| crc >> 1 ^ (0xedb8_8320 & (crc & 1).wrapping_neg()))
    })
}

#[test]
fn a_package_has_the_stage_of_the_run_and_its_images() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    fs::create_dir(at("textures")).unwrap();
    for (name, bytes) in [("wood grain.png", PNG), ("textures/wood_grain.jpeg", JPEG), ("old.tga", b"tga")] {
        fs::write(at(name), bytes).unwrap();
    }
    let library = "newmtl a\nmap_Kd wood grain.png\nnewmtl b\nmap_Kd textures/wood_grain.jpeg\nnewmtl c\nmap_Kd \
                   old.tga\n";
    fs::write(at("block.mtl"), library).unwrap();
    let mut model = BLOCK
        .replace("o Block\n", "mtllib block.mtl\no Block\nvt 0 0\n")
        .replace("f 4 3 2 1", "usemtl a\nf 4/1 3/1 2/1 1/1");
    for (line, material) in [("f 5 6", "b"), ("f 1 2", "c")] {
        model = model.replace(line, &format!("usemtl {material}\n{line}"));
    }
    fs::write(at("block.obj"), model).unwrap();
    let report = job(folder.path(), "out", &[]).run(&mut ()).unwrap();
    assert_eq!(written(&at("out")).keys().collect::<Vec<_>>(), ["supple.usdz"]);
    let package = fs::read(at("out/supple.usdz")).unwrap();
    let found = files(&package);
    let names: Vec<&str> = found.iter().map(|(name, _)| name.as_str()).collect();
    assert_eq!(names, ["stage.usdc", "images/wood_grain.png", "images/wood_grain_2.jpg"]);
    assert!(found[0].1.starts_with(b"PXR-USDC"));
    assert_eq!((found[1].1, found[2].1), (PNG, JPEG));
    let contains = |text: &[u8]| found[0].1.windows(text.len()).any(|bytes| bytes == text);
    assert!(contains(b"./images/wood_grain.png\0") && contains(b"./images/wood_grain_2.jpg\0"));
    assert!(!contains(b"old.tga"));
    let lines = report.files.join("\n");
    assert!(
        lines.contains("supple.usdz: without the image")
            && lines.contains("old.tga: it cannot be read, or is neither PNG nor JPEG"),
        "{lines}"
    );
}

#[test]
fn stopped_and_killed_runs_have_the_package_of_an_uninterrupted_run() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    fs::write(at("block.obj"), BLOCK).unwrap();
    let mut whole = job(folder.path(), "whole", &["output.format=[\"usd\", \"usdz\"]"]);
    whole.checkpoint_interval = Duration::ZERO;
    // The copy has a frame after the checkpoint.
    whole.run(&mut CopyAfter { frame: 5, from: at("whole"), to: at("killed") }).unwrap();
    let expected = written(&at("whole"));
    let package = &expected["supple.usdz"];
    // Without images the stages are the same.
    assert!(files(package)[0].1 == expected["supple.usd"]);
    let resumed = |out: &str, overrides: &[&str], stop: u32| {
        let mut job = job(folder.path(), out, &[&["output.format=[\"usd\", \"usdz\"]"], overrides].concat());
        (job.resume, job.verify) = (true.into(), true);
        job.run(&mut StopAfter(stop)).unwrap()
    };
    assert_eq!(resumed("killed", &[], 99).resumed_after, Some(4));
    assert!(written(&at("killed")) == expected);
    // A stopped run has the package of its frames.
    assert_eq!(resumed("stopped", &[], 3).outcome, Outcome::Stopped);
    let stopped = fs::read(at("stopped/supple.usdz")).unwrap();
    assert!(files(&stopped)[0].1.len() < files(package)[0].1.len());
    assert_eq!(resumed("stopped", &[], 99).resumed_after, Some(3));
    assert!(written(&at("stopped")) == expected);
    assert_eq!(resumed("stopped", &[], 99).outcome, Outcome::AlreadyFinished);
    // A frame of a complete package is changed.
    let mut changed = package.clone();
    changed[64 + 96 + 40] ^= 1;
    fs::write(at("stopped/supple.usdz"), &changed).unwrap();
    assert_eq!(resumed("stopped", &[], 99).outcome, Outcome::Finished);
    assert!(written(&at("stopped")) == expected);
    // More frames start again, because a complete package keeps none to continue.
    assert_eq!(resumed("stopped", &["simulation.frames=9"], 99).resumed_after, None);
}
