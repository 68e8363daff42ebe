//! Laws of a square bar of the thickness t and the length l, with Young's modulus E, Poisson's ratio ν and so the shear
//! modulus G = E/(2 (1 + ν)).

use std::f64::consts::{PI, TAU};

/// Torsion constant of a square, over t⁴ (Saint-Venant).
pub(super) const TORSION: f64 = 0.140_577;

/// A square bar.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bar {
    /// Thickness t.
    pub(super) thickness: f64,
    /// Length l.
    pub(super) length: f64,
    /// Young's modulus E.
    pub(super) modulus: f64,
    /// Poisson's ratio ν.
    pub(super) poisson_ratio: f64,
    /// Density ρ.
    pub(super) density: f64,
}

impl Bar {
    /// Returns the speed √(E/ρ) of a longitudinal wave.
    pub(super) fn speed(&self) -> f64 {
        (self.modulus / self.density).sqrt()
    }

    /// Returns the shear modulus G.
    fn shear_modulus(&self) -> f64 {
        self.modulus / (2.0 * (1.0 + self.poisson_ratio))
    }

    /// Returns the bulk modulus K = E/(3 (1 - 2 ν)).
    pub(super) fn bulk_modulus(&self) -> f64 {
        self.modulus / (3.0 * (1.0 - 2.0 * self.poisson_ratio))
    }

    /// Returns the shear factor k of a square: 10 (1 + ν)/(12 + 11 ν) (Cowper 1966).
    fn shear_factor(&self) -> f64 {
        10.0 * (1.0 + self.poisson_ratio) / (12.0 + 11.0 * self.poisson_ratio)
    }

    /// Returns the force per strain, E A.
    pub(super) fn tensile_stiffness(&self) -> f64 {
        self.modulus * self.thickness.powi(2)
    }

    /// Returns the bending moment per curvature, E I.
    pub(super) fn bending_stiffness(&self) -> f64 {
        self.modulus * self.thickness.powi(4) / 12.0
    }

    /// Returns the torque per twist, G J, with the torsion constant J.
    pub(super) fn torsional_stiffness(&self) -> f64 {
        self.shear_modulus() * TORSION * self.thickness.powi(4)
    }

    /// Returns the lowest frequency of stretch of the free bar in Hz: √(E/ρ)/(2 l).
    pub(super) fn stretch(&self) -> f64 {
        self.speed() / (2.0 * self.length)
    }

    /// Returns the lowest frequency of twist of the free bar in Hz: √(G J/(ρ I))/(2 l), with the torsion constant J and
    /// the polar moment I = t⁴/6 of the cross-section.
    pub(super) fn twist(&self) -> f64 {
        let inertia = self.density * self.thickness.powi(4) / 6.0;
        (self.torsional_stiffness() / inertia).sqrt() / (2.0 * self.length)
    }

    /// Returns the lowest frequency of bending of the free bar in Hz, by the beam of Timoshenko with free ends (Huang
    /// 1961, "The effect of rotatory inertia and of shear deformation on the frequency and normal mode equations of
    /// uniform beams with simple end conditions"): the first root b of
    /// 2 - 2 cosh bα cos bβ + b/√(1 - b² r² s²) (b² r² (r² - s²)² + 3 r² - s²) sinh bα sin bβ = 0.
    pub(super) fn bending(&self) -> f64 {
        let r2 = (self.thickness / self.length).powi(2) / 12.0;
        let s2 = r2 * self.modulus / (self.shear_factor() * self.shear_modulus());
        let frequency_equation = |b: f64| {
            let root = ((r2 - s2).powi(2) + 4.0 / (b * b)).sqrt();
            let (alpha, beta) = (((root - r2 - s2) / 2.0).sqrt(), ((root + r2 + s2) / 2.0).sqrt());
            let factor =
                (b * b * r2 * (r2 - s2).powi(2) + 3.0 * r2 - s2) * b / (1.0 - b * b * r2 * s2).sqrt();
            2.0 - 2.0 * (b * alpha).cosh() * (b * beta).cos() + factor * (b * alpha).sinh() * (b * beta).sin()
        };
        // Of the Euler-Bernoulli beam b is 22.37; shear and rotation of the cross-section lower it.
        let (mut low, mut high) = (1.0, 1.0);
        while frequency_equation(high).signum() == frequency_equation(low).signum() {
            (low, high) = (high, high + 0.05);
        }
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            match frequency_equation(middle).signum() == frequency_equation(low).signum() {
                true => low = middle,
                false => high = middle,
            }
        }
        low * r2.sqrt() * self.speed() / (TAU * self.length)
    }

    /// Returns the deflection of the end of the bar under its weight, held at the other end, in small gravity g across
    /// it: ρ A g l⁴/(8 E I) + ρ A g l²/(2 k G A), Euler-Bernoulli with shear.
    pub(super) fn deflection(&self, gravity: f64) -> f64 {
        let l = self.length;
        let shear = self.shear_factor() * self.shear_modulus() * self.thickness.powi(2);
        let load = self.density * gravity * self.thickness.powi(2);
        load * (l.powi(4) / (8.0 * self.bending_stiffness()) + l * l / (2.0 * shear))
    }

    /// Returns the elongation of the bar that hangs from its upper end in gravity g: ρ g l²/(2 E).
    pub(super) fn elongation(&self, gravity: f64) -> f64 {
        self.density * gravity * self.length.powi(2) / (2.0 * self.modulus)
    }
}

/// Lowest mode of a free bar or a cantilever.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Mode {
    Stretch,
    Bend,
    Twist,
    /// Bending of a bar that is held at its lower end.
    Cantilever,
}

impl Mode {
    /// Returns the shape of the mode: the displacement, of the order of 1, at x and y from the axis and at the fraction
    /// z of the length l.
    pub(super) fn displacement(self, x: f64, y: f64, z: f64, length: f64) -> [f64; 3] {
        match self {
            Self::Stretch => [0.0, 0.0, (PI * z).cos()],
            Self::Twist => {
                let angle = (PI * z).cos();
                [-angle * y, angle * x, 0.0]
            }
            Self::Bend => bent([4.730_040_7, 0.982_502_2], 1.0, x, z, length),
            Self::Cantilever => bent([1.875_104_1, 0.734_095_5], -1.0, x, z, length),
        }
    }
}

/// Returns the displacement of a bent beam, cosh kz ± cos kz - σ (sinh kz ± sin kz), with the rotation of its
/// cross-sections (Euler-Bernoulli).
fn bent([k, sigma]: [f64; 2], sign: f64, x: f64, z: f64, length: f64) -> [f64; 3] {
    let p = k * z;
    let deflection = p.cosh() + sign * p.cos() - sigma * (p.sinh() + sign * p.sin());
    let slope = k / length * (p.sinh() - sign * p.sin() - sigma * (p.cosh() + sign * p.cos()));
    [deflection, 0.0, -x * slope]
}

#[cfg(test)]
mod tests {
    use super::*;

    const BAR: Bar = Bar { thickness: 1.0, length: 5.0, modulus: 1e5, poisson_ratio: 0.0, density: 1000.0 };

    /// Returns the lowest elastic angular frequency of a beam of Timoshenko by 200 linear elements with one integration
    /// point, by inverse iteration on the stiffness matrix plus a small part of the mass matrix.
    fn by_finite_elements(bar: Bar) -> f64 {
        const ELEMENTS: usize = 200;
        let (area, inertia) = (bar.thickness.powi(2), bar.thickness.powi(4) / 12.0);
        let h = bar.length / ELEMENTS as f64;
        let size = 2 * (ELEMENTS + 1);
        let (mut stiffness, mut mass) =
            (nalgebra::DMatrix::<f64>::zeros(size, size), nalgebra::DVector::<f64>::zeros(size));
        for element in 0..ELEMENTS {
            // Deflection and rotation at both nodes: strain of shear (w2 - w1)/h - (r1 + r2)/2, curvature (r2 - r1)/h.
            let shear = [-1.0 / h, -0.5, 1.0 / h, -0.5];
            let curvature = [0.0, -1.0 / h, 0.0, 1.0 / h];
            for (i, j) in (0..4).flat_map(|i| (0..4).map(move |j| (i, j))) {
                stiffness[(2 * element + i, 2 * element + j)] += h
                    * (bar.shear_factor() * bar.shear_modulus() * area * shear[i] * shear[j]
                        + bar.modulus * inertia * curvature[i] * curvature[j]);
            }
            for (i, moment) in [area, inertia, area, inertia].into_iter().enumerate() {
                mass[2 * element + i] += 0.5 * h * bar.density * moment;
            }
        }
        let scale = mass.map(|m| 1.0 / m.sqrt());
        let matrix = nalgebra::DMatrix::from_fn(size, size, |i, j| stiffness[(i, j)] * scale[i] * scale[j]);
        let mut eigenvalues = matrix.symmetric_eigenvalues().as_slice().to_vec();
        eigenvalues.sort_by(f64::total_cmp);
        // The first two are those of the rigid motions.
        eigenvalues[2].sqrt()
    }

    #[test]
    fn the_bending_frequency_is_that_of_timoshenkos_beam() {
        for (length, poisson_ratio) in [(3.0, 0.0), (5.0, 0.0), (20.0, 0.0), (3.0, 0.45)] {
            let bar = Bar { length, poisson_ratio, ..BAR };
            let ratio = bar.bending() * TAU / by_finite_elements(bar);
            // The error of the elements is of the order of (4.73/200)²/12 = 5e-5, and a few times that for shear.
            assert!((ratio - 1.0).abs() < 5e-4, "{length}, {poisson_ratio}: {ratio}");
        }
        // A slender bar is one of Euler and Bernoulli.
        let slender = Bar { length: 100.0, ..BAR };
        let euler = 22.373_285 * (1.0 / 12.0_f64).sqrt() * 10.0 / (TAU * 100.0 * 100.0);
        assert!((slender.bending() / euler - 1.0).abs() < 2e-3, "{} {euler}", slender.bending());
    }

    #[test]
    fn the_shapes_of_the_modes_meet_their_ends() {
        let slope = |mode: Mode, z: f64| -mode.displacement(1.0, 0.0, z, 5.0)[2];
        let deflection = |mode: Mode, z: f64| mode.displacement(0.0, 0.0, z, 5.0)[0];
        assert!(
            deflection(Mode::Cantilever, 0.0).abs() < 1e-12 && slope(Mode::Cantilever, 0.0).abs() < 1e-12
        );
        assert!((deflection(Mode::Cantilever, 1.0) - 2.0).abs() < 1e-6);
        assert!(
            (deflection(Mode::Bend, 0.0) - 2.0).abs() < 1e-6
                && (deflection(Mode::Bend, 1.0) - 2.0).abs() < 1e-6
        );
        for mode in [Mode::Bend, Mode::Cantilever] {
            // The slope is the derivative of the deflection along the length 5.
            let difference = (deflection(mode, 0.301) - deflection(mode, 0.299)) / 0.01;
            assert!((difference - slope(mode, 0.3)).abs() < 1e-5, "{mode:?}");
        }
    }
}
