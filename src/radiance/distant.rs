//! Radiance's sources: light from a cone of directions. Up to below 180 degrees one is a sun; from there, or under a sky's function, it
//! is a part of the environment.

use std::fmt::Write as _;

use glam::DVec3;

use crate::Result;
use crate::radiance::Scene;
use crate::radiance::material::{Glare, Material};
use crate::radiance::modifier::{Pattern, Resolved};
use crate::radiance::object::Object;
use crate::radiance::read::Around;
use crate::radiance::write::{key, list, number};
use crate::scene::light::MOST_PARTS;

/// A part of the environment.
pub struct Part {
    toward: DVec3,
    angle_deg: f64,
    glare: Glare,
    sky: Option<Pattern>,
}

impl Scene {
    /// Takes a source.
    pub fn source(&mut self, object: &Object, around: &Around, resolved: &Resolved) -> Result<()> {
        let [x, y, z, angle_deg] = object.exactly("x y z of the direction to it, angle")?;
        let toward = around.motion.vector(DVec3::new(x, y, z)).normalize_or_zero();
        if toward == DVec3::ZERO || !(angle_deg > 0.0 && angle_deg <= 360.0) {
            return Err(
                object.wrong("expected a direction with a length, and an angle above 0 and at most 360 degrees")
            );
        }
        let shine = match &resolved.material {
            Some(Material::Light(shine)) if shine.spot.is_none() => shine,
            None | Some(Material::Invisible) => {
                self.leave_out("source without light");
                return Ok(());
            }
            _ => return Err(object.wrong("a source that is no light, illum or glow is not read")),
        };
        let glare = self.palette.glare(shine, resolved);
        if glare.luminance <= 0.0 {
            return Ok(());
        }
        if resolved.sky.is_none() && angle_deg < 180.0 {
            let name = self.palette.unique(&around.name(&object.name));
            let (direction, angle) = (list(toward.to_array()), number(angle_deg));
            // A String takes it.
            let _ = write!(
                self.suns,
                "\n[lights.{}]\ntype = \"sun\"\ndirection = {direction}\ndiameter_deg = {angle}\n{}",
                key(&name),
                glare.keys()
            );
            return Ok(());
        }
        if self.sky.len() == MOST_PARTS {
            return Err(object.wrong(format!("more than {MOST_PARTS} sources of 180 degrees or with a sky's function")));
        }
        self.sky.push(Part { toward, angle_deg, glare, sky: resolved.sky.clone() });
        Ok(())
    }
}

/// The table of the environment.
pub fn environment(parts: &[Part]) -> String {
    let plain = |p: &Part| p.sky.is_none() && (p.angle_deg == 180.0 || p.angle_deg == 360.0);
    match parts {
        [] => String::new(),
        [one] if plain(one) => {
            let half = one.angle_deg == 180.0;
            let up =
                if half { format!("upper_half = true\nup = {}\n", list(one.toward.to_array())) } else { String::new() };
            format!("\n[environment]\ntype = \"uniform\"\n{up}{}", one.glare.keys())
        }
        parts => {
            let mut text = "\n[environment]\ntype = \"distant\"\n".to_string();
            for part in parts {
                let (toward, angle) = (list(part.toward.to_array()), number(part.angle_deg));
                // A String takes them.
                let _ = write!(
                    text,
                    "\n[[environment.part]]\ntoward = {toward}\nangle_deg = {angle}\n{}",
                    part.glare.keys()
                );
                if let Some(sky) = &part.sky {
                    let _ = writeln!(text, "{} = {}", sky.key, list(sky.numbers.iter().copied()));
                    if list(sky.zenith) != "[0, 0, 1]" {
                        let _ = writeln!(text, "sky_up = {}", list(sky.zenith));
                    }
                }
            }
            text
        }
    }
}
