//! A surface met by a ray, as its material sees it.

use glam::Vec3A;

use crate::material::Lobes;
use crate::medium::Inside;
use crate::scene::{Hit, Scene, ray};

/// A surface that a path has met, in the frame of its shading normal.
pub struct Meeting {
    /// The geometric normal on the side that the path came from.
    pub side: Vec3A,
    /// Where.
    pub point: Vec3A,
    /// The largest coordinate that it was computed from; 0 for a point that is off its surface.
    pub reach: f32,
    /// The shading normal last.
    pub axes: [Vec3A; 3],
    /// To where the path came from, in this frame.
    pub out: Vec3A,
    /// The shading normal is the surface's own, and what is known of the material so far shows the same from everywhere.
    pub matt: bool,
    /// The medium behind the front, and whether the path came from before it.
    pub interior: Option<(u32, bool)>,
}

impl Meeting {
    /// `front` says which side of the surface the path came from, `shading` is the front's normal.
    pub fn new(hit: &Hit, front: bool, shading: Vec3A, direction: Vec3A) -> Meeting {
        let side = if front { hit.normal } else { -hit.normal };
        let mut z = if front { shading } else { -shading };
        // An interpolated normal can turn away from who looks at it.
        let turned = z.dot(direction) > -1e-4;
        if turned {
            z = side;
        }
        let (x, y) = ray::frame(z);
        let mut meeting = Meeting {
            side,
            point: hit.point,
            reach: hit.reach,
            axes: [x, y, z],
            out: Vec3A::Z,
            matt: !turned,
            interior: None,
        };
        meeting.out = meeting.local(-direction);
        meeting.out.z = meeting.out.z.max(1e-6);
        meeting
    }

    /// Turns the first tangent along a direction of the scene; one along the normal says nothing.
    pub fn align(&mut self, axis: Vec3A) {
        let [.., z] = self.axes;
        let axis = axis.normalize_or_zero();
        let x = axis - z * axis.dot(z);
        // What rounding leaves of one along the normal is no direction.
        if x.length_squared() > 1e-8 {
            let x = x.normalize();
            let back = self.world(self.out);
            self.axes = [x, z.cross(x), z];
            self.out = self.local(back);
        }
    }

    /// The same with all the lobes of the scene's material there.
    pub fn with_lobes<'a>(scene: &'a Scene, hit: &Hit, direction: Vec3A) -> (Meeting, Lobes<'a>) {
        let front = hit.normal.dot(direction) < 0.0;
        let (site, shading) = scene.site(hit, front);
        let mut meeting = Meeting::new(hit, front, shading, direction);
        let material = &scene.materials[hit.surface.material as usize];
        if scene.effects.aligns
            && let Some(axis) = material.axis(&site)
        {
            meeting.align(axis.as_vec3a());
        }
        if scene.effects.fills {
            meeting.interior = material.interior().map(|medium| (medium, front));
        }
        let mut lobes = Lobes::default();
        material.lobes(&site, meeting.out, &mut lobes);
        (meeting, lobes)
    }

    /// A point that is off its surface, seen along the normal: where irradiance is asked for.
    pub fn facing(point: Vec3A, normal: Vec3A) -> Meeting {
        let (x, y) = ray::frame(normal);
        Meeting { side: normal, point, reach: 0.0, axes: [x, y, normal], out: Vec3A::Z, matt: false, interior: None }
    }

    /// The bodies that a place beyond the surface is in, by those of a place on this side.
    #[inline]
    pub fn beyond(&self, inside: Inside) -> Inside {
        self.interior.map_or(inside, |(medium, front)| inside.beyond(Some(medium), front))
    }

    /// A direction in this frame.
    pub fn local(&self, v: Vec3A) -> Vec3A {
        Vec3A::new(v.dot(self.axes[0]), v.dot(self.axes[1]), v.dot(self.axes[2]))
    }

    /// And back.
    pub fn world(&self, v: Vec3A) -> Vec3A {
        self.axes[0] * v.x + self.axes[1] * v.y + self.axes[2] * v.z
    }

    /// Normal of the side on which a lobe's light arrives, and a start of rays there.
    pub fn start(&self, transmits: bool) -> (Vec3A, Vec3A) {
        let side = if transmits { -self.side } else { self.side };
        (ray::offset(self.point, side, self.reach), side)
    }
}
