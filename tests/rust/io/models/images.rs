//! Images inside of models: frames of all formats with materials have them, the right side up.

use std::fs;
use std::path::Path;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use gltf::Gltf;
use serde_json::json;
use supple_io::model;
use supple_io::obj::{Document, Image};
use supple_io::run::{Job, Outcome};
use supple_io::scene::{Scene, Up};

use super::files::{self, cube};
use crate::run_files::{StopAfter, written};

/// Number of columns and rows of the image: a pixel per vertex of a cube.
const SIZE: [u32; 2] = [4, 2];

/// Returns the color of the pixel of a vertex.
fn color(vertex: usize) -> [u8; 3] {
    [10 * vertex as u8, 255 - 20 * vertex as u8, 7]
}

/// Returns an image as PNG. Its pixels are row by row from the top down.
fn png() -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, SIZE[0], SIZE[1]);
    encoder.set_color(png::ColorType::Rgb);
    let pixels: Vec<u8> = (0..8).flat_map(color).collect();
    encoder.write_header().unwrap().write_image_data(&pixels).unwrap();
    bytes
}

/// Returns the color of an image at texture coordinates whose origin is at the upper left.
fn color_at(image: &[u8], [u, v]: [f32; 2]) -> [u8; 3] {
    let mut reader = png::Decoder::new(std::io::Cursor::new(image)).read_info().unwrap();
    let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
    reader.next_frame(&mut pixels).unwrap();
    let at = (v * SIZE[1] as f32) as usize * SIZE[0] as usize + (u * SIZE[0] as f32) as usize;
    pixels.as_chunks().0[at]
}

/// How the image is in the model.
#[derive(Clone, Copy, PartialEq)]
enum Place {
    View,
    Address,
}

/// Returns a cube of triangles with the image.
fn model_with(image: &[u8], place: Place) -> files::Gltf {
    let mut gltf = cube().triangulated().gltf(false);
    let coordinates: Vec<[f32; 2]> =
        (0..8).map(|vertex| [(vertex % 4) as f32 / 4.0 + 0.125, (vertex / 4) as f32 / 2.0 + 0.25]).collect();
    let coordinates = gltf.floats(&coordinates);
    let primitive = &mut gltf.root["meshes"][0]["primitives"][0];
    (primitive["attributes"]["TEXCOORD_0"], primitive["material"]) = (coordinates, json!(0));
    gltf.root["materials"] =
        json!([{ "name": "painted", "pbrMetallicRoughness": { "baseColorTexture": { "index": 0 } } }]);
    gltf.root["textures"] = json!([{ "source": 1 }]);
    let found = match place {
        Place::View => {
            let views = gltf.root["bufferViews"].as_array_mut().unwrap();
            views.push(json!({ "buffer": 0, "byteOffset": gltf.buffer.len(), "byteLength": image.len() }));
            let found = json!({ "bufferView": views.len() - 1, "mimeType": "image/png" });
            gltf.buffer.extend(image);
            gltf.buffer.resize(gltf.buffer.len().next_multiple_of(4), 0);
            found
        }
        Place::Address => json!({ "uri": format!("data:image/png;base64,{}", STANDARD.encode(image)) }),
    };
    // The first image is that of no material.
    gltf.root["images"] = json!([{ "uri": "other.png" }, found]);
    gltf
}

fn job(folder: &Path, model: &str, formats: &str) -> Job {
    let overrides = [format!("output.format={formats}"), "body.0.name=it".to_owned()];
    let mut scene = Scene::open(folder.join(model), Up::Y, &overrides).unwrap();
    scene.simulation.frames = 6;
    Job::new(scene, folder.join(format!("frames of {model}")))
}

/// Checks that each corner of a GLB file has the color of its vertex.
fn check_glb(bytes: &[u8]) {
    let gltf = Gltf::from_slice(bytes).unwrap();
    let buffer = gltf.blob.clone().unwrap();
    let primitive = gltf.meshes().next().unwrap().primitives().next().unwrap();
    let texture = primitive.material().pbr_metallic_roughness().base_color_texture().unwrap().texture();
    let gltf::image::Source::View { view, mime_type } = texture.source().unwrap().source() else { panic!() };
    assert_eq!(mime_type, "image/png");
    let image = &buffer[view.offset()..view.offset() + view.length()];
    assert!(image == png());
    let coordinates = primitive.reader(|_| Some(&buffer[..])).read_tex_coords(0).unwrap().into_f32();
    let colors: Vec<[u8; 3]> = coordinates.map(|pair| color_at(image, pair)).collect();
    assert_eq!(colors, (0..8).map(color).collect::<Vec<_>>());
}

#[test]
fn images_inside_of_models_are_in_or_beside_the_frames() {
    let folder = tempfile::tempdir().unwrap();
    let image = png();
    for (name, bytes) in [
        ("view.glb", model_with(&image, Place::View).glb()),
        ("address.gltf", model_with(&image, Place::Address).embedded()),
    ] {
        fs::write(folder.path().join(name), bytes).unwrap();
        let job = job(folder.path(), name, r#"["obj", "usd", "glb", "html", "ply"]"#);
        job.run(&mut ()).unwrap();
        let files = written(&job.directory);
        // A file of the image for the formats that need one.
        assert!(files["it_image1.png"] == image);
        assert_eq!(files["it_frames.mtl"], b"newmtl painted\nKd 1 1 1\nd 1\nmap_Kd it_image1.png\n");
        let frame = Document::read(job.directory.join("it_0003.obj")).unwrap();
        let expected = Image::File(job.directory.join("it_image1.png"));
        assert_eq!(frame.material_colors()["painted"].image, Some(expected));
        let part = frame.part(None).unwrap();
        let appearance = frame.appearance(&part);
        for (&vertex, &corner) in part.mesh().faces().flatten().zip(&appearance.corners) {
            // The origin of OBJ is at the lower left.
            let [u, v] = appearance.coordinates[corner as usize];
            assert_eq!(color_at(&image, [u, 1.0 - v]), color(vertex as usize));
        }
        let stage = &files["supple.usd"];
        assert!(stage.windows(16).any(|text| text == b"./it_image1.png\0" || text == b"\0./it_image1.png"));
        check_glb(&files["supple.glb"]);
        let mut textures = job.clone();
        textures.scene.output.format = supple_io::frames::Format::Vat.into();
        textures.directory = folder.path().join(format!("textures of {name}"));
        textures.run(&mut ()).unwrap();
        check_glb(&fs::read(textures.directory.join("it_vat/it.glb")).unwrap());
        let manifest = fs::read(job.directory.join("manifest.json")).unwrap();
        let manifest: serde_json::Value = serde_json::from_slice(&manifest).unwrap();
        let listed = manifest["files"].as_array().unwrap();
        assert!(listed.iter().any(|file| file["name"] == "it_image1.png" && file["bytes"] == image.len()));
        // An exported file is a model again.
        let again = model::read_document(job.directory.join("supple.glb")).unwrap();
        assert!(
            matches!(&again.material_colors()["painted"].image, Some(Image::Embedded(found)) if found.bytes == image)
        );
    }
}

#[test]
fn only_formats_that_need_files_write_images_and_a_resumed_run_has_them() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("view.glb"), model_with(&png(), Place::View).glb()).unwrap();
    let mut job = job(folder.path(), "view.glb", r#"["glb", "ply", "html"]"#);
    job.run(&mut ()).unwrap();
    assert!(!job.directory.join("it_image1.png").exists());

    job.scene.output.format = supple_io::frames::Format::Usd.into();
    assert_eq!(job.run(&mut StopAfter(2)).unwrap().outcome, Outcome::Stopped);
    let image = job.directory.join("it_image1.png");
    fs::remove_file(&image).unwrap();
    job.resume = true.into();
    assert_eq!(job.run(&mut ()).unwrap().outcome, Outcome::Finished);
    assert!(fs::read(&image).unwrap() == png());
    let before = fs::metadata(&image).unwrap().modified().unwrap();
    assert_eq!(job.run(&mut ()).unwrap().outcome, Outcome::AlreadyFinished);
    assert_eq!(fs::metadata(&image).unwrap().modified().unwrap(), before);
}

#[test]
fn images_of_other_types_and_beyond_their_buffer_are_left_out_and_told() {
    let mut beyond = model_with(&png(), Place::View);
    let last = beyond.root["bufferViews"].as_array().unwrap().len() - 1;
    beyond.root["bufferViews"][last]["byteLength"] = json!(1_000_000_000);
    let mut address = model_with(&png(), Place::Address);
    address.root["images"][1]["uri"] = json!("data:image/png;base64,???");
    for gltf in [beyond, address, model_with(b"RIFF....WEBP", Place::View)] {
        let document = model::from_bytes("it.glb", gltf.glb()).unwrap();
        assert_eq!(document.material_colors()["painted"].image, None);
        assert_eq!(document.ignored_parts(), ["1 image missing, or neither PNG nor JPEG"]);
    }
}
