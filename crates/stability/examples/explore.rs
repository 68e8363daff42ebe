use std::io::Write;
fn main() {
    let only = std::env::args().nth(1).unwrap_or_default();
    let cases: Vec<_> = supple_stability::cases()
        .into_iter()
        .filter(|c| format!("{} {}", c.family, c.name).contains(&only))
        .collect();
    supple_stability::run_all(&cases, std::env::var("T").map_or(1, |t| t.parse().unwrap()), |i, ran| {
        let c = &cases[i];
        let f = &ran.outcome.figures;
        let _ = writeln!(
            std::io::stdout(),
            "{} {} | {:.2}s {:?}",
            if ran.outcome.passed() { "ok  " } else { "FAIL" },
            c.name,
            ran.elapsed.as_secs_f64(),
            ran.outcome.error
        );
        let _ = writeln!(
            std::io::stdout(),
            "      {}",
            f.values.iter().map(|(m, v)| format!("{m:?} {v:.2e}")).collect::<Vec<_>>().join("  ")
        );
        if std::env::var("SERIES").is_ok() {
            let _ = writeln!(
                std::io::stdout(),
                "      {:?}",
                f.energy.iter().map(|(s, e)| (*s, format!("{e:.3e}"))).collect::<Vec<_>>()
            );
        }
        true
    });
}
