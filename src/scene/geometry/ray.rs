//! A ray made ready for boxes and for watertight triangles.

use glam::Vec3A;

/// Constants of one ray through one tree.
#[derive(Clone, Copy, Debug)]
pub struct Ray {
    /// Start.
    pub origin: Vec3A,
    /// Direction of any length; distances are in units of it.
    pub direction: Vec3A,
    /// Reciprocal of the direction; huge, not infinite, where that is zero.
    pub inverse: [f32; 3],
    /// Origin for the slabs' near planes, moved ahead of the true one by the rounding of the crossings.
    pub near: [f32; 3],
    /// Origin for the slabs' far planes, moved back likewise.
    pub far: [f32; 3],
    /// 1 where the direction is negative.
    pub sign: [usize; 3],
    /// The axis of the direction's largest component last, the two others before it.
    pub axes: [usize; 3],
    /// Direction's components along these axes over the largest, and the largest's reciprocal.
    pub shear: [f32; 3],
}

/// Below this a direction's component counts as zero in the box test: its reciprocal times any distance is still finite.
const TINY: f32 = 1e-18;

impl Ray {
    /// `None` where origin or direction are no numbers to trace with. `low` and `high` bound the tree.
    #[inline(always)]
    pub fn new(origin: Vec3A, direction: Vec3A, low: Vec3A, high: Vec3A) -> Option<Ray> {
        let size = direction.abs();
        let z = if size.x > size.y && size.x > size.z {
            0
        } else if size.y > size.z {
            1
        } else {
            2
        };
        let d = direction.to_array();
        let scale = 1.0 / d[z];
        if !(origin.is_finite() && direction.is_finite() && scale.is_finite() && scale != 0.0) {
            return None;
        }
        let (x, y) = [(1, 2), (2, 0), (0, 1)][z];
        // Vertices relative to the origin are rounded by half a unit in the last place of the largest of them, the shear
        // and the slabs' distances add a few more: boxes grow by that, so that none is missed which holds a crossing
        // (Woop, Benthin and Wald 2013, section 3.3).
        let extent = (low - origin).abs().max((high - origin).abs()).max_element();
        let slack = extent * (6.0 * f32::EPSILON);
        let o = origin.to_array();
        let mut ray = Ray {
            origin,
            direction,
            inverse: [0.0; 3],
            near: [0.0; 3],
            far: [0.0; 3],
            sign: [0; 3],
            axes: [x, y, z],
            shear: [d[x] * scale, d[y] * scale, scale],
        };
        for k in 0..3 {
            ray.inverse[k] = if d[k].abs() < TINY { (1.0 / TINY).copysign(d[k]) } else { 1.0 / d[k] };
            let ahead = slack.copysign(d[k]);
            ray.near[k] = o[k] + ahead;
            ray.far[k] = o[k] - ahead;
            ray.sign[k] = usize::from(d[k].is_sign_negative());
        }
        Some(ray)
    }
}
