//! The energies of the reference method.

use nalgebra::Vector3;

use super::naive::Naive;
use super::region_motion::RegionMotion;

impl Naive<'_> {
    /// Computes half the sum, over all vertices of all regions, of the weighted squared distance from the
    /// vertex to its rest position moved by the rigid motion of the region, and of the potential of its volume term,
    /// times the stiffness factor of the region.
    ///
    /// The gradient of this sum with respect to the position x_i of vertex i is `s_i m_i (x_i - g_i)`, where m_i
    /// is the mass, g_i the goal position, and s_i the stiffness factor of the vertex. Multiplied by `alpha / dt^2` and
    /// the mass of a full cell, the sum is the elastic energy of the body.
    ///
    /// # Panics
    ///
    /// If the number of motions is not the number of regions, or that of positions not the number of lattice vertices.
    pub fn matching_energy(&self, motions: &[RegionMotion], positions: &[Vector3<f64>]) -> f64 {
        assert_eq!(motions.len(), self.region_count(), "`motions` must match the regions");
        assert_eq!(positions.len(), self.lattice.len(), "`positions` must match the lattice vertices");
        let of_region = |(region, motion): (u32, &RegionMotion)| -> f64 {
            let members = self.members(region);
            let distance = |i: u32| positions[i as usize] - motion.rigid_goal(self.rest(i));
            let sum: f64 = members.iter().map(|&i| self.weight(i) * distance(i).norm_squared()).sum();
            self.factor(region)
                * self.share(region)
                * (sum + 2.0 * motion.mass * motion.stretch.powi(2) * motion.volume_energy)
        };
        self.regions().zip(motions).map(of_region).sum::<f64>() / 2.0
    }

    /// Computes the energy of a body whose velocities change by `alpha * (g - x)` times the stiffness factor of the
    /// vertex in each step, where g are the goal positions and x the positions.
    ///
    /// The unit of mass is the mass of a full cell, the unit of length is the unit of the positions, and the
    /// unit of time is one step. `velocities`: the velocities before the change.
    ///
    /// These steps are steps of the leapfrog method, which does not conserve the sum of the kinetic and the
    /// elastic energy. For a harmonic motion it conserves the sum returned here. This is the elastic energy
    /// at the positions, plus a kinetic energy in which the product of the velocities before and after the
    /// change replaces the square of the velocity. Growth of this sum is therefore an error of the method.
    ///
    /// # Panics
    ///
    /// If the number of positions or velocities is not the number of lattice vertices.
    pub fn energy(&self, positions: &[Vector3<f64>], velocities: &[Vector3<f64>], alpha: f64) -> f64 {
        assert_eq!(velocities.len(), self.lattice.len(), "`velocities` must match the lattice vertices");
        let motions = self.motions(positions);
        let goals = self.goals(&motions);
        let factors = self.vertex_factors();
        let vertices = goals.iter().zip(positions).zip(velocities).zip(&self.weights.masses).zip(&factors);
        let kinetic =
            vertices.map(|((((goal, x), v), m), s)| 0.5 * m * v.dot(&(v + (goal - x) * (alpha * s))));
        kinetic.sum::<f64>() + alpha * self.matching_energy(&motions, positions)
    }
}
