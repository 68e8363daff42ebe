//! Reading OBJ files: everything that real files hold, and what is refused.

use std::path::PathBuf;

use supple::obj;

fn scene(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../examples/scenes").join(name)
}

#[test]
fn the_bust_is_read() {
    let bust = obj::read(scene("bust.obj")).unwrap();
    assert_eq!((bust.vertices().len(), bust.face_count()), (4682, 4716));
    assert!(bust.is_closed() && bust.signed_volume() > 0.0);
    assert_eq!(bust.topology().components.len(), 1);
    let parts = obj::Document::read(scene("bust_parts.obj")).unwrap();
    assert_eq!(parts.mesh(None).unwrap().topology().components.len(), 6);
    assert_eq!(parts.groups().count(), 6);
}
