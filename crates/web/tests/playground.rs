//! Tests of the playground without a browser.

use supple_web::{Playground, Settings};

const BUST: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../examples/scenes/bust.obj");
const BALL: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../examples/scenes/ball.obj");

fn playground(path: &str, settings: &Settings) -> Playground {
    Playground::new("model.obj", std::fs::read(path).unwrap(), settings).unwrap()
}

/// Returns the corners of the bounding box.
fn bounds(points: &[[f32; 3]]) -> [[f32; 3]; 2] {
    let corner = |choose: fn(f32, f32) -> f32, start| {
        std::array::from_fn(|axis| points.iter().map(|point| point[axis]).fold(start, choose))
    };
    [corner(f32::min, f32::INFINITY), corner(f32::max, f32::NEG_INFINITY)]
}

fn highest(points: &[[f32; 3]]) -> usize {
    (0..points.len()).max_by(|&a, &b| points[a][1].total_cmp(&points[b][1])).unwrap()
}

fn distance(a: [f32; 3], b: [f32; 3]) -> f32 {
    (0..3).map(|axis| (a[axis] - b[axis]).powi(2)).sum::<f32>().sqrt()
}

/// Pulls the top of a body by a displacement for a second. Returns the top, and its place before.
fn pull_top(playground: &mut Playground, [x, y, z]: [f64; 3]) -> (usize, [f32; 3]) {
    let top = highest(playground.surface());
    let place = playground.surface()[top];
    let [a, b, c] = place.map(f64::from);
    playground.grab(1, a, b, c).unwrap();
    for frame in 1..=60 {
        let share = f64::from(frame.min(30)) / 30.0;
        playground.drag(1, share * x, share * y, share * z).unwrap();
        playground.advance(1).unwrap();
    }
    playground.evaluate();
    (top, place)
}

#[test]
fn grabbed_part_follows_and_volume_is_preserved() {
    let mut playground = playground(BUST, &Settings::default());
    let (top, place) = pull_top(&mut playground, [0.1, 0.25, 0.0]);
    let target = [place[0] + 0.1, place[1] + 0.25, place[2]];
    // The top lies in cells that are held: it deviates by less than the width of a cell, about a tenth.
    let off = distance(playground.surface()[top], target);
    assert!(off < 0.02, "{off}");
    assert!(playground.volume_error().abs() < 1e-6);
    assert!(playground.volume_error_before().abs() > 0.01);
    let mut settings = Settings::default();
    settings.volume = false;
    playground.apply(&settings).unwrap();
    playground.evaluate();
    assert!(playground.volume_error().abs() > 0.01);
    playground.release(1).unwrap();
    playground.advance(600).unwrap();
    playground.evaluate();
    // At rest it is bent a little by its weight.
    let off = distance(playground.surface()[top], place);
    assert!(off < 0.1, "{off}");
    assert!(playground.is_at_rest());
}

#[test]
fn reset_restores_the_start_exactly() {
    let mut playground = playground(BALL, &Settings::default());
    let start = playground.surface().to_vec();
    pull_top(&mut playground, [0.3, 0.0, 0.1]);
    assert_ne!(playground.surface(), start);
    playground.reset().unwrap();
    assert_eq!(playground.surface(), start);
    // The pointer has let go.
    assert!(playground.drag(1, 0.0, 0.0, 0.0).is_err());
}

#[test]
fn models_of_any_size_stand_on_the_floor_with_a_longest_side_of_one() {
    let mut lines = String::new();
    let (text, mut heights) = (std::fs::read_to_string(BALL).unwrap(), Vec::new());
    for (scale, offset) in [(1.0, 0.0), (1e-6, 3.0), (1e6, -1e7)] {
        lines.clear();
        for line in text.lines() {
            match line.strip_prefix("v ") {
                None => lines.push_str(line),
                Some(numbers) => {
                    let numbers = numbers.split_whitespace().map(|number| number.parse::<f64>().unwrap());
                    // The offset of a tiny model would exceed the digits of the file.
                    let offset = if scale < 1.0 { offset * scale } else { offset };
                    let words = numbers.map(|number| (number * scale + offset).to_string());
                    lines.push_str(&format!("v {}", words.collect::<Vec<_>>().join(" ")));
                }
            }
            lines.push('\n');
        }
        let playground =
            Playground::new("ball.obj", lines.clone().into_bytes(), &Settings::default()).unwrap();
        let [low, high] = bounds(playground.surface());
        for axis in 0..3 {
            // Coordinates of 1e7 have steps of 1 in a file of f32, 1e-6 of the model.
            assert!((high[axis] - low[axis] - 1.0).abs() < 1e-5, "{scale}: {low:?} {high:?}");
        }
        // A body that is held stands just above the floor.
        assert!((low[1] - 0.01).abs() < 1e-5 && (low[0] + high[0]).abs() < 1e-5, "{scale}: {low:?} {high:?}");
        heights.push(playground.lattice_vertices());
    }
    assert_eq!(heights[0], heights[1]);
}

#[test]
fn z_up_turns_the_model_upright() {
    let mut settings = Settings::default();
    let [_, high] = bounds(playground(BUST, &settings).surface());
    settings.set_up("z").unwrap();
    let turned = playground(BUST, &settings);
    let [low, turned_high] = bounds(turned.surface());
    // What was up, y, points to the viewer, -z.
    assert!((turned_high[2] - low[2] - (high[1] - 0.01)).abs() < 1e-5);
    assert!((low[1] - 0.01).abs() < 1e-5);
}

#[test]
fn settings_change_a_body_that_is_dragged() {
    let mut settings = Settings::default();
    settings.lattice_vertices = 300;
    let mut playground = playground(BALL, &settings);
    let soft = playground.steps_per_frame();
    pull_top(&mut playground, [0.2, 0.2, 0.0]);
    let before = playground.surface().to_vec();
    settings.set_material("firm").unwrap();
    settings.floor = false;
    settings.gravity = 1.62;
    settings.base = false;
    playground.apply(&settings).unwrap();
    playground.evaluate();
    // The correction of the surface depends on the material, but the lattice has not moved.
    let moved = before.iter().zip(playground.surface()).map(|(a, b)| distance(*a, *b)).fold(0.0, f32::max);
    assert!(moved < 0.01, "{moved}");
    // The next step chooses the number of steps.
    playground.advance(1).unwrap();
    assert!(playground.steps_per_frame() > soft);
    settings.lattice_vertices = 2000;
    playground.apply(&settings).unwrap();
    assert!((1900..=2100).contains(&playground.lattice_vertices()));
    // Without a base and a floor it falls: 1.62/2 m/s² · 1 s².
    let [low, _] = bounds(playground.surface());
    playground.advance(60).unwrap();
    playground.evaluate();
    let [fallen, _] = bounds(playground.surface());
    assert!((low[1] - fallen[1] - 0.81).abs() < 0.02, "{low:?} {fallen:?}");
}

#[test]
fn poisson_ratio_is_that_of_the_material_until_it_is_set() {
    let mut settings = Settings::default();
    for (material, ratio) in [("jelly", 0.45), ("flesh", 0.45), ("rubber", 0.4), ("firm", 0.3)] {
        settings.set_material(material).unwrap();
        assert_eq!(settings.poisson_ratio, ratio, "{material}");
    }
    assert_eq!(Settings::default().poisson_ratio, 0.45);
    // The volume without the correction changes less, the greater Poisson's ratio is.
    let mut stretched = [0.0, 0.45].map(|ratio| {
        let mut settings = Settings::default();
        settings.lattice_vertices = 300;
        settings.poisson_ratio = ratio;
        let mut playground = playground(BALL, &settings);
        pull_top(&mut playground, [0.0, 0.4, 0.0]);
        (playground, settings)
    });
    let [without, with] = stretched.each_ref().map(|(playground, _)| playground.volume_error_before());
    assert!(without > 0.05 && with.abs() < 0.5 * without, "{without} {with}");
    let [(playground, settings), _] = &mut stretched;
    settings.poisson_ratio = 0.45;
    playground.apply(settings).unwrap();
    playground.advance(60).unwrap();
    playground.evaluate();
    assert!((playground.volume_error_before() - with).abs() < 0.1 * without);
    settings.poisson_ratio = 0.5;
    let error = playground.apply(settings).unwrap_err().to_string();
    assert_eq!(error, "poisson_ratio = 0.5 is out of range: it must be in [0, 0.47]");
}

#[test]
fn a_body_at_rest_inflates_to_its_ratio_and_back() {
    let mut settings = Settings::default();
    settings.lattice_vertices = 300;
    settings.floor = false;
    settings.gravity = 0.0;
    settings.base = false;
    let mut playground = playground(BALL, &settings);
    let width = |playground: &Playground| {
        let [low, high] = bounds(playground.surface());
        high[0] - low[0]
    };
    let start = width(&playground);
    for ratio in [1.5, 0.5, 1.0] {
        settings.inflate = ratio;
        playground.apply(&settings).unwrap();
        playground.advance(240).unwrap();
        playground.evaluate();
        assert!((playground.rest_volume_ratio() - ratio).abs() < 1e-6);
        assert!(playground.volume_error().abs() < 1e-6);
        let expected = start * ratio.cbrt() as f32;
        assert!((width(&playground) - expected).abs() < 0.01 * expected, "{ratio}: {}", width(&playground));
    }
    // Reset begins with the volume of the model, from which the body is inflated again.
    settings.inflate = 2.0;
    playground.apply(&settings).unwrap();
    playground.reset().unwrap();
    assert_eq!(playground.rest_volume_ratio(), 1.0);
    playground.advance(1).unwrap();
    playground.evaluate();
    assert!((playground.rest_volume_ratio() - 2.0).abs() < 1e-6);
    settings.inflate = 0.0;
    assert!(playground.apply(&settings).unwrap_err().to_string().starts_with("inflate = 0 is out of range"));
}

#[test]
fn wind_blows_a_body_away_from_its_rest_and_a_weak_grip_lags_behind_the_pointer() {
    let mut settings = Settings::default();
    settings.lattice_vertices = 300;
    let mut playground = playground(BALL, &settings);
    playground.advance(120).unwrap();
    playground.evaluate();
    let top = highest(playground.surface());
    let rest = playground.surface()[top];
    settings.wind = 10.0;
    playground.apply(&settings).unwrap();
    playground.advance(120).unwrap();
    playground.evaluate();
    assert!(playground.surface()[top][0] > rest[0] + 0.001, "{:?} {rest:?}", playground.surface()[top]);
    assert!(!playground.is_at_rest());
    // Without the wind it is where it was.
    settings.wind = 0.0;
    playground.apply(&settings).unwrap();
    playground.advance(600).unwrap();
    playground.evaluate();
    assert!(distance(playground.surface()[top], rest) < 0.001);

    let reached = |grip: f64| {
        let mut settings = settings;
        settings.grip = grip;
        let mut playground = self::playground(BALL, &settings);
        let (top, place) = pull_top(&mut playground, [0.0, 0.3, 0.0]);
        playground.surface()[top][1] - place[1]
    };
    let [weak, strong, held] = [0.1, 0.5, 1.0].map(reached);
    assert!(0.0 < weak && weak < strong && strong < held && held > 0.25, "{weak} {strong} {held}");
    settings.grip = 0.0;
    playground.apply(&settings).unwrap();
    let error = playground.grab(1, 0.0, 1.0, 0.0).unwrap_err().to_string();
    assert!(error.contains("weight = 0"), "{error}");
}

#[test]
fn errors_name_the_file_and_the_line() {
    let message = |text: &str| {
        Playground::new("broken.obj", text.into(), &Settings::default()).unwrap_err().to_string()
    };
    assert_eq!(
        message("v 0 0 0\nv 1 0 0\nv 0 1 zero\nf 1 2 3\n"),
        "broken.obj:3: `zero` in `v` is not a number; write numbers like 1.5 or 2e-3"
    );
    assert!(
        message("v 0 0 0\nv 1 0 0\nf 1 2 9\n").starts_with("broken.obj:3: face 1 refers to vertex 9 of 2")
    );
    let error = Settings::default().set_material("steel").unwrap_err().to_string();
    assert_eq!(error, "material `steel` is not known; use jelly, flesh, rubber, firm");
}
