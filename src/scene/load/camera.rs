//! `[camera]`.

use crate::Result;
use crate::keys::Keys;
use crate::scene::camera::{Camera, Lens, Projection};
use crate::scene::load::point;
use crate::view::Kind;

const TYPES: &str = "expected perspective, parallel, fisheye, hemispherical, planispheric, cylinder or panorama";

/// Reads it; lengths times `metres` are metres.
pub fn read(mut k: Keys, metres: f64) -> Result<Camera> {
    let (kind, span) = k.get_spanned::<String>("type")?.unwrap_or(("perspective".into(), 0..0));
    let origin = point(&mut k, "origin")? * metres;
    let target = point(&mut k, "target")? * metres;
    let up = point(&mut k, "up")?;
    let (projection, extent) = match kind.as_str() {
        "perspective" => (Projection::Perspective, k.need("fov_deg")?),
        "parallel" => (Projection::Parallel, k.need::<f64>("width_seen")? * metres),
        "fisheye" => (Projection::Wide(Kind::Angular), k.get("fov_deg")?.unwrap_or(180.0)),
        "hemispherical" => (Projection::Wide(Kind::Hemispherical), k.get("fov_deg")?.unwrap_or(180.0)),
        "planispheric" => (Projection::Wide(Kind::Planispheric), k.get("fov_deg")?.unwrap_or(180.0)),
        "cylinder" => (Projection::Wide(Kind::Cylindrical), k.get("fov_deg")?.unwrap_or(360.0)),
        "panorama" => (Projection::Panorama, 360.0),
        _ => return Err(k.wrong_key("type", span, TYPES)),
    };
    let whole = |x: f64| (1.0..=1e6).contains(&x) && x.fract() == 0.0;
    let right = "must be a whole number of pixels from 1";
    let width = k.number("width", right, whole)?.unwrap_or(512.0);
    let square = if projection == Projection::Panorama { (width / 2.0).ceil() } else { width };
    let height = k.number("height", right, whole)?.unwrap_or(square);
    let camera = Camera::new(projection, origin, target, up, extent, (width as usize, height as usize));
    let camera = camera.map_err(|e| k.wrong(&e.to_string()))?;
    let mut camera = match lens(&mut k, metres)? {
        None => camera,
        Some(lens) => camera.with_lens(lens).ok_or_else(|| k.wrong("only a perspective has a lens"))?,
    };
    let pupil = k.number("pupil_mm", "must be above 0 and at most 1e6", |x| x > 0.0 && x <= 1e6)?;
    camera.pupil_m = pupil.map(|mm| mm / 1000.0);
    k.finish()?;
    Ok(camera)
}

/// `lens_radius` and `focus`, lengths.
fn lens(k: &mut Keys, metres: f64) -> Result<Option<Lens>> {
    let positive = |x: f64| x > 0.0 && x < 1e9;
    let radius = k.number("lens_radius", "must be above 0", positive)?;
    let focus = k.number("focus", "must be above 0", positive)?;
    match (radius, focus) {
        (None, None) => Ok(None),
        (Some(r), Some(f)) => Ok(Some(Lens { radius_m: r * metres, focus_m: f * metres })),
        _ => Err(k.wrong("lens_radius and focus go together")),
    }
}
