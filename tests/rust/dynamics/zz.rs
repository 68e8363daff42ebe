use supple::*;
#[test]
fn zz() {
    let (v, f) = supple_tests::sphere([0.0, 0.0, 0.0], 1.0, 40);
    let mesh = supple_tests::mesh_of((v, f));
    for nu in [0.0, 0.3, 0.45] {
        let body = Body::builder(mesh.clone()).lattice_vertices(1000).preset(Preset::Flesh).poisson_ratio(nu).translate([0.0, 1.02, 0.0]).build().unwrap();
        let floor = Collider::plane([0.0; 3], [0.0, 1.0, 0.0]);
        let mut sim = Simulation::builder().body(body).collider(floor).fps(30.0).substeps(Substeps::Auto).sleep(false).build().unwrap();
        sim.advance(150);
        let h = sim.body(0).lattice().cell_size();
        println!("nu {nu} w {} steps {:?} h {h} alpha?", sim.body(0).half_width(), sim.dt());
        let mut last = sim.body(0).positions();
        let mut worst = 0;
        for k in 0..12 {
            sim.step();
            let x = sim.body(0).positions();
            let d: Vec<f64> = x.iter().zip(&last).map(|(a, b)| (a - b).norm() / h).collect();
            if k == 0 { worst = (0..d.len()).max_by(|a, b| d[*a].total_cmp(&d[*b])).unwrap(); }
            let c = sim.contacts();
            let n = c.len();
            let deep = c.iter().map(|c| c.depth).fold(f64::MIN, f64::max) / h;
            println!("{k} max {:.2e} worst idx {:?} y {:.5} dy {:.5} contacts {n} deep {deep:.2e}", d.iter().copied().fold(0.0, f64::max), sim.body(0).lattice().indices()[worst], x[worst].y / h, (x[worst].y - last[worst].y) / h);
            last = x;
        }
    }
}
