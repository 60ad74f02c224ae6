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

/// A direction's component below this counts as zero in the box test: its reciprocal times any distance is still finite. A
/// direction of no larger component is none.
const TINY: f32 = 1e-18;

/// For the axis of the largest component: the two others in turn, then it.
const AXES: [[usize; 3]; 3] = [[1, 2, 0], [2, 0, 1], [0, 1, 2]];

impl Ray {
    /// `None` where origin or direction are no numbers to trace with. `low` and `high` bound the tree.
    #[inline(always)]
    pub fn new(origin: Vec3A, direction: Vec3A, low: Vec3A, high: Vec3A) -> Option<Ray> {
        let size = direction.abs();
        // By sums and a table: which axis it is no processor guesses.
        let (x, y) = ((size.x > size.y) & (size.x > size.z), size.y > size.z);
        let axes = AXES[usize::from(!x) * (2 - usize::from(y))];
        let d = direction.to_array();
        let longest = d[axes[2]];
        if !(origin.is_finite() && direction.is_finite() && longest.abs() >= TINY) {
            return None;
        }
        // Vertices relative to the origin are rounded by half a unit in the last place of the largest of them, the shear
        // and the slabs' distances add a few more: boxes grow by that, so that none is missed which holds a crossing
        // (Woop, Benthin and Wald 2013, section 3.3).
        let extent = (low - origin).abs().max((high - origin).abs()).max_element();
        let ahead = Vec3A::splat(extent * (6.0 * f32::EPSILON)).copysign(direction);
        let tiny = Vec3A::splat(TINY);
        let inverse = Vec3A::select(size.cmplt(tiny), tiny.copysign(direction), direction).recip().to_array();
        let scale = inverse[axes[2]];
        Some(Ray {
            origin,
            direction,
            inverse,
            near: (origin + ahead).to_array(),
            far: (origin - ahead).to_array(),
            sign: [(d[0].to_bits() >> 31) as usize, (d[1].to_bits() >> 31) as usize, (d[2].to_bits() >> 31) as usize],
            axes,
            shear: [d[axes[0]] * scale, d[axes[1]] * scale, scale],
        })
    }
}
