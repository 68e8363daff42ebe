//! Writes frame sequences: the evaluated surface of each body, as files that other programs read.
//!
//! | format | files | contents |
//! |---|---|---|
//! | [`Format::Obj`] | `NAME_0000.obj`, ... | the bytes of the input file, with new positions and normals |
//! | [`Format::Ply`] | `NAME_0000.ply`, ... | positions, vertex normals and faces, binary little endian |
//! | [`Format::Pc2`] | `NAME.pc2` | Point Cache 2: positions of all frames, in input vertex order |
//! | [`Format::Usd`] | `supple.usd` | a USD stage with all bodies and frames of a run |
//! | [`Format::Usdz`] | `supple.usdz` | a USD stage with its images |
//! | [`Format::Html`] | `supple.html` | a page for browsers, with all bodies and frames of a run |
//! | [`Format::Glb`] | `supple.glb` | glTF 2.0: nodes with morph targets, with all bodies and frames of a run |
//! | [`Format::Vat`] | `NAME_vat/` | vertex animation textures |
//! | [`Format::Vtu`] | `NAME_0000.vtu`, ..., `NAME.pvd` | grids of VTK: positions, normals and faces |
//! | [`Format::Film`], [`Format::Gif`] | `supple.webp`, `supple.gif` | a moving picture of a run |
//! | [`Format::Lattice`] | `NAME_0000.lattice.vtu`, ..., `NAME.lattice.pvd` | grids of VTK: the cells of the lattice |
//!
//! A [`Sequence`] names the files, and a [`FrameWriter`] writes them from positions and a [`Source`], the
//! input of the body. The writer uses one of four modules:
//!
//! * `obj`: OBJ from an OBJ file, with `normal_transform` for its `vn` and `library_path` for its `mtllib`;
//! * `plain`: OBJ from arrays;
//! * `ply`;
//! * `pc2`.
//!
//! When a body breaks, the writer builds its texts again for the mesh of the [`Pieces`]: `obj_pieces` those of OBJ
//! files, with `piece_normals` for their `vn` and `obj_context` for faces at the end of the file. `refined` writes the
//! file of a refined mesh in the same way.
//!
//! A USD stage, and a package of it, is written by a `StageWriter`. A page or a film is written by a `PageWriter`, and
//! GLB files and textures by a `ClipWriter`; both keep the frames in a file of their own until the run ends. Grids are
//! written by a `GridWriter`. A run uses them through the trait `FrameSink`; the table in `kinds` says how the files of
//! a format are opened, checked and completed, and `format` what they are called.
//!
//! A `Record` is the size and the hash of a written frame. A resumed run finds the files of its sequences with
//! a `Listing`, and compares them with the records of the earlier run (`present`, and `single_file` for files with all
//! frames).
//!
//! Every file is written under a temporary name (with `.part` appended) and renamed when it is complete. A
//! file with a final name is therefore always complete.

mod broken_surface;
mod clip;
mod error;
mod film;
mod format;
mod grids;
mod kinds;
mod library_path;
mod listing;
mod normal_transform;
mod number;
mod obj;
mod obj_context;
mod obj_pieces;
mod options;
mod page;
mod page_data;
mod pc2;
mod per_frame;
mod piece_normals;
mod pieces;
mod plain;
mod ply;
mod present;
mod read_pc2;
mod record;
mod refined;
mod sequence;
mod single_file;
mod sink;
mod source;
mod stage;
mod writer;

pub use error::OutputError;
pub use format::{Format, Formats, UnknownFormat};
pub use grids::lattice_frame_bytes;
pub(crate) use kinds::{check_run, open_sink};
pub(crate) use library_path::written_images;
pub(crate) use listing::{Listing, SetAside, check_inputs};
pub use normal_transform::count_shared_normals;
pub(crate) use per_frame::Renames;
pub use pieces::Pieces;
pub(crate) use present::{Present, check, check_link, finish};
pub use read_pc2::{PointCacheData, read_pc2};
pub(crate) use record::{Compare, Record, Recorder};
pub(crate) use refined::refined;
pub use sequence::Sequence;
pub(crate) use sink::{BodyFrame, Ending, FrameRun, FrameSink};
pub use source::Source;
pub use writer::FrameWriter;

pub use crate::vat::VatEncoding;
pub use options::FormatOptions;
