//! Files: OBJ, frames, pages, stages and scenes, with fuzzers of the readers.

mod broken_pages;
mod disabled_colliders;
mod film;
mod frames;
mod fuzz;
mod fuzz_obj;
mod fuzz_scene;
mod glb;
mod glb_colliders;
mod grids;
mod input_messages;
mod input_time;
mod models;
mod obj;
mod obj_frames;
mod packages;
mod page_reader;
mod pages;
mod piece_frames;
mod run_files;
mod scene;
mod scene_input;
mod stages;
mod vat;
