//! Wind.

use crate::error::{Result, check};

/// How air acts on cloth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum WindForce {
    /// Every particle is pushed alike: its acceleration is `response` \[1/s\] times the velocity of the air relative to
    /// it. One look at the noise a particle.
    Push {
        /// Larger means that cloth takes up the wind's velocity sooner. At least 0.
        response: f32,
    },
    /// Drag along the air that passes each triangle, and lift across it, by the triangle's normal:
    /// `0.5 density area |n.v| (drag v + lift (v x n) x v / |v|)` with n on the side that the air goes to. One more pass over the grid.
    Triangles {
        /// Density of the air \[kg/m^3\], 1.2 at sea level. At least 0.
        density: f32,
        /// Drag coefficient; about 1 for a plate across the wind. At least 0.
        drag: f32,
        /// Lift coefficient. At least 0.
        lift: f32,
    },
}

/// Wind with gusts: a uniform velocity, whose heading (about +y) a noise field turns from place to place; the field
/// drifts with the wind. Forces on triangles read its velocity at each particle at the start of the frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wind {
    /// Velocity of the air \[m/s\].
    pub velocity: [f32; 3],
    /// Largest angle \[rad\] by which gusts turn the heading, 0 to 3. 0 is uniform wind.
    pub gust: f32,
    /// Distance \[m\] over which gusts differ, above 0.
    pub gust_size: f32,
    /// How it acts.
    pub force: WindForce,
}

impl Wind {
    /// Refuses numbers outside their ranges.
    pub fn check(&self) -> Result<()> {
        for x in self.velocity {
            check("the velocity of the wind [m/s]", f64::from(x), "finite", |_| true)?;
        }
        check("the angle of gusts [rad]", f64::from(self.gust), "0 to 3", |g| (0.0..=3.0).contains(&g))?;
        check("the size of gusts [m]", f64::from(self.gust_size), "above 0", |s| s > 0.0)?;
        let coefficients = match self.force {
            WindForce::Push { response } => [response; 3],
            WindForce::Triangles { density, drag, lift } => [density, drag, lift],
        };
        for x in coefficients {
            check("a coefficient of the wind", f64::from(x), "at least 0", |c| c >= 0.0)?;
        }
        Ok(())
    }
}
