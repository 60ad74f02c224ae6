//! What a lens does, as a TOML file: light lost toward the edge, a neutral filter, which part of the picture counts, and how it was seen.
//!
//! ```toml
//! projection = "fisheye"               # perspective, fisheye (equal angles), hemispherical, planispheric, cylinder, panorama
//! fov_deg = 180                        # whole angle across the part that counts; a panorama has none
//! circle = [2736, 1824, 1810]          # x, y and radius in pixels: what counts of a fisheye; or
//! rect = [0, 0, 5472, 3648]            # x, y, width, height
//! density = [3.01, 2.98, 2.95]         # of a neutral filter, by channel; or transmittance = [...]; one number for all three
//! [vignetting]                         # light that arrives, 1 in the middle, in one of three ways
//! radius = [[0, 1], [0.5, 0.93], [1, 0.61]]   # straight between points; 1 is the circle's edge, else half the diagonal
//! angle_deg = [[0, 1], [45, 0.9], [90, 0.48]] # over the angle from the middle of the view; needs a projection
//! polynomial = [1, 0, -0.31, 0, -0.08]        # c0 + c1 r + c2 r^2 ...
//! centre = [2731, 1829]                # of radius and polynomial, if it is not the circle's or the picture's
//! ```
//!
//! Pixels are counted from the left and the top of the upright picture, 0, 0 the corner of the first. Light is divided by all that is
//! lost; what lies outside the circle is black. The picture is cut to the circle's square, or the rectangle, and VIEW is of what is left.

use crate::keys::{self, Keys};
use crate::view::{Kind, View};
use crate::{Error, Result, invalid};

/// Light that arrives may be so little, or so much.
const SOUND: std::ops::RangeInclusive<f64> = 0.01..=2.0;
/// Most points or coefficients.
const MOST: usize = 4096;

/// Names of projections; `None` is the whole sphere.
const PROJECTIONS: [(&str, Option<Kind>); 6] = [
    ("perspective", Some(Kind::Perspective)),
    ("fisheye", Some(Kind::Angular)),
    ("hemispherical", Some(Kind::Hemispherical)),
    ("planispheric", Some(Kind::Planispheric)),
    ("cylinder", Some(Kind::Cylindrical)),
    ("panorama", None),
];

/// Light lost toward the edge.
#[derive(Clone, Debug, PartialEq)]
enum Vignetting {
    None,
    Radius(Vec<[f64; 2]>),
    Angle(Vec<[f64; 2]>),
    Polynomial(Vec<f64>),
}

/// What counts of the picture.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Crop {
    All,
    Circle([f64; 3]),
    Rect([usize; 4]),
}

/// What the file says.
#[derive(Clone, Debug, PartialEq)]
pub struct Description {
    /// The angle is of the whole width.
    projection: Option<(Option<Kind>, f64)>,
    crop: Crop,
    transmittance: [f64; 3],
    vignetting: Vignetting,
    centre: Option<[f64; 2]>,
}

/// A lens on pictures of one size.
#[derive(Clone, Debug)]
pub struct Lens {
    /// First column and row that count, width and height of what does.
    pub part: [usize; 4],
    /// The header's line, without a newline.
    pub view_line: Option<String>,
    /// What to multiply the channels by for the filter.
    pub factors: [f64; 3],
    circle: Option<[f64; 3]>,
    vignetting: Vignetting,
    centre: [f64; 2],
    /// Pixels of a radius of 1.
    unit: f64,
    view: Option<View>,
}

impl Description {
    /// Reads the file. Errors name line, column and key.
    pub fn parse(text: &str) -> Result<Description> {
        let mut k = keys::parse(text)?;
        let projection = match k.get_spanned::<String>("projection")? {
            None => None,
            Some((name, span)) => match PROJECTIONS.iter().find(|p| p.0 == name) {
                Some((_, Some(kind))) => {
                    let fov = k.number("fov_deg", "must be above 5 and at most 360", |x| x > 5.0 && x <= 360.0)?;
                    Some((Some(*kind), fov.ok_or_else(|| k.wrong("key 'fov_deg' is missing"))?))
                }
                Some((_, None)) => Some((None, 360.0)),
                None => {
                    let known = PROJECTIONS.map(|p| p.0).join(", ");
                    return Err(k.wrong_key("projection", span, &format!("there are {known}")));
                }
            },
        };
        let crop = match (k.get::<[f64; 3]>("circle")?, k.get::<[usize; 4]>("rect")?) {
            (Some(_), Some(_)) => return Err(k.wrong("circle and rect: only one of them can count")),
            (Some(c), None) if c.iter().all(|x| x.is_finite()) && c[2] >= 1.0 => Crop::Circle(c),
            (Some(_), None) => return Err(k.wrong("circle: expected x, y and a radius of 1 pixel or more")),
            (None, Some(r)) if r[2] > 0 && r[3] > 0 => Crop::Rect(r),
            (None, Some(_)) => return Err(k.wrong("rect: expected x, y, width and height, these above 0")),
            (None, None) => Crop::All,
        };
        let transmittance = transmittance(&mut k)?;
        let (vignetting, centre) = match k.table("vignetting")? {
            None => (Vignetting::None, None),
            Some(v) => vignetting(v, &projection)?,
        };
        k.finish()?;
        Ok(Description { projection, crop, transmittance, vignetting, centre })
    }

    /// The lens on pictures of that size.
    pub fn fit(&self, width: usize, height: usize) -> Result<Lens> {
        let (w, h) = (width as f64, height as f64);
        let (part, circle) = match self.crop {
            Crop::All => ([0, 0, width, height], None),
            Crop::Rect([x, y, across, down]) => {
                if x.saturating_add(across) > width || y.saturating_add(down) > height {
                    return invalid!("rect: reaches beyond the picture of {width} x {height} pixels");
                }
                ([x, y, across, down], None)
            }
            Crop::Circle([x, y, r]) => {
                let (left, top) = ((x - r).round(), (y - r).round());
                let side = (2.0 * r).round();
                if left < 0.0 || top < 0.0 || left + side > w || top + side > h {
                    return invalid!("circle: reaches beyond the picture of {width} x {height} pixels");
                }
                ([left as usize, top as usize, side as usize, side as usize], Some([x, y, r]))
            }
        };
        let (view, view_line) = match self.projection {
            None => (None, None),
            Some((None, _)) => (None, Some("PROJECTION=latlong".into())),
            Some((Some(kind), fov)) => {
                let vertical = vertical_deg(kind, fov, part[3] as f64 / part[2] as f64);
                let text = format!("-vt{} -vh {fov} -vv {vertical}", kind.word());
                let view = View::parse(&text).filter(|v| v.vertical_deg.is_finite());
                let view = view.ok_or_else(|| {
                    Error::Invalid(format!(
                        "fov_deg: {fov} is too wide for this projection and {} x {}",
                        part[2], part[3]
                    ))
                })?;
                (Some(view), Some(format!("VIEW= {text}")))
            }
        };
        let centre = self.centre.or(circle.map(|c| [c[0], c[1]])).unwrap_or([0.5 * w, 0.5 * h]);
        Ok(Lens {
            part,
            view_line,
            factors: self.transmittance.map(|t| 1.0 / t),
            circle,
            vignetting: self.vignetting.clone(),
            centre,
            unit: circle.map_or(0.5 * w.hypot(h), |c| c[2]),
            view,
        })
    }
}

impl Lens {
    /// No lens at all.
    pub fn none(width: usize, height: usize) -> Lens {
        Lens {
            part: [0, 0, width, height],
            view_line: None,
            factors: [1.0; 3],
            circle: None,
            vignetting: Vignetting::None,
            centre: [0.0; 2],
            unit: 1.0,
            view: None,
        }
    }

    /// What to multiply a pixel's light by, at its middle; `None` outside the circle.
    pub fn gain(&self, x: usize, y: usize) -> Option<f64> {
        let (x, y) = (x as f64 + 0.5, y as f64 + 0.5);
        if self.circle.is_some_and(|[cx, cy, r]| (x - cx).hypot(y - cy) > r) {
            return None;
        }
        let radius = || (x - self.centre[0]).hypot(y - self.centre[1]) / self.unit;
        let arrives = match &self.vignetting {
            Vignetting::None => return Some(1.0),
            Vignetting::Radius(table) => between(table, radius()),
            Vignetting::Polynomial(c) => polynomial(c, radius()),
            Vignetting::Angle(table) => {
                let [left, top, width, height] = self.part.map(|n| n as f64);
                let view = self.view?;
                let direction = view.direction((x - left) / width, 1.0 - (y - top) / height);
                between(table, direction.map_or(180.0, |d| d[2].clamp(-1.0, 1.0).acos().to_degrees()))
            }
        };
        Some(1.0 / arrives.clamp(*SOUND.start(), *SOUND.end()))
    }
}

/// The whole angle up and down of a picture of square pixels, `aspect` as high as wide.
fn vertical_deg(kind: Kind, horizontal_deg: f64, aspect: f64) -> f64 {
    let half = (horizontal_deg / 2.0).to_radians();
    let vertical = match kind {
        Kind::Perspective => (half.tan() * aspect).atan(),
        Kind::Cylindrical => (half * aspect).atan(),
        Kind::Hemispherical => (half.sin() * aspect).asin(),
        Kind::Angular => half * aspect,
        Kind::Planispheric => 2.0 * ((half / 2.0).tan() * aspect).atan(),
    };
    // Without the last bits: 40 shall not read 39.99999999999999.
    (2.0 * vertical.to_degrees() * 1e9).round() / 1e9
}

/// Straight between points, level beyond them.
fn between(table: &[[f64; 2]], x: f64) -> f64 {
    let i = table.partition_point(|p| p[0] <= x);
    match (i.checked_sub(1).map(|i| table[i]), table.get(i)) {
        (Some(a), Some(b)) => a[1] + (b[1] - a[1]) * (x - a[0]) / (b[0] - a[0]),
        (Some(a), None) => a[1],
        (None, first) => first.map_or(1.0, |p| p[1]),
    }
}

fn polynomial(coefficients: &[f64], x: f64) -> f64 {
    coefficients.iter().rev().fold(0.0, |sum, c| sum * x + c)
}

/// One number for three channels, or one each.
#[derive(serde::Deserialize)]
#[serde(untagged)]
enum Channels {
    All(f64),
    Each([f64; 3]),
}

impl Channels {
    fn three(self) -> [f64; 3] {
        match self {
            Channels::All(x) => [x; 3],
            Channels::Each(x) => x,
        }
    }
}

fn transmittance(k: &mut Keys) -> Result<[f64; 3]> {
    let (density, share) = (k.get_spanned::<Channels>("density")?, k.get_spanned::<Channels>("transmittance")?);
    let (key, t, span) = match (density, share) {
        (None, None) => return Ok([1.0; 3]),
        (Some((d, span)), None) => ("density", d.three().map(|d| 10f64.powf(-d)), span),
        (None, Some((t, span))) => ("transmittance", t.three(), span),
        (Some(_), Some(_)) => return Err(k.wrong("density and transmittance: only one of them can count")),
    };
    if t.iter().all(|t| (1e-9..=1.0).contains(t)) {
        Ok(t)
    } else {
        Err(k.wrong_key(key, span, "a filter lets through a share above 0 and at most 1"))
    }
}

fn vignetting(mut v: Keys, projection: &Option<(Option<Kind>, f64)>) -> Result<(Vignetting, Option<[f64; 2]>)> {
    let ways = (
        v.get_spanned::<Vec<[f64; 2]>>("radius")?,
        v.get_spanned::<Vec<[f64; 2]>>("angle_deg")?,
        v.get_spanned::<Vec<f64>>("polynomial")?,
    );
    let centre = v.get::<[f64; 2]>("centre")?;
    if centre.is_some_and(|c| c.iter().any(|x| !x.is_finite())) {
        return Err(v.wrong("centre: expected x and y in pixels"));
    }
    let rising = |t: &[[f64; 2]]| {
        let sorted = t.windows(2).all(|w| w[0][0] < w[1][0]);
        sorted && (1..=MOST).contains(&t.len()) && t.iter().all(|p| p[0] >= 0.0 && SOUND.contains(&p[1]))
    };
    let table = "expected pairs of a place that rises and the light there, 0.01 to 2";
    let way = match ways {
        (Some((t, _)), None, None) if rising(&t) => Vignetting::Radius(t),
        (Some((_, span)), None, None) => return Err(v.wrong_key("radius", span, table)),
        (None, Some((t, span)), None) if rising(&t) => {
            if !matches!(projection, Some((Some(_), _))) {
                return Err(v.wrong_key("angle_deg", span, "needs a projection that has angles from its middle"));
            }
            Vignetting::Angle(t)
        }
        (None, Some((_, span)), None) => return Err(v.wrong_key("angle_deg", span, table)),
        (None, None, Some((c, span))) => {
            let sound = |i: u32| SOUND.contains(&polynomial(&c, f64::from(i) / 256.0));
            if c.len() > MOST || !(0..=256).all(sound) {
                return Err(v.wrong_key("polynomial", span, "must lie in 0.01 to 2 for radii of 0 to 1"));
            }
            Vignetting::Polynomial(c)
        }
        (None, None, None) => return Err(v.wrong("expected radius, angle_deg or polynomial")),
        _ => return Err(v.wrong("radius, angle_deg and polynomial: only one of them can count")),
    };
    v.finish()?;
    Ok((way, centre))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_fisheye_is_cut_to_its_circle() {
        let text = "projection = 'fisheye'\nfov_deg = 180\ncircle = [60, 50, 40]\ndensity = [1, 2, 3]\n\
            [vignetting]\nangle_deg = [[0, 1], [90, 0.5]]\n";
        let lens = Description::parse(text).unwrap().fit(120, 100).unwrap();
        assert_eq!(lens.part, [20, 10, 80, 80]);
        assert_eq!(lens.view_line.as_deref(), Some("VIEW= -vta -vh 180 -vv 180"));
        assert!((lens.factors[2] / 1000.0 - 1.0).abs() < 1e-12);
        assert_eq!(lens.gain(20, 10), None);
        // The pixel right of the middle, and one 30.5 pixels to the right: 68.6 degrees.
        assert!((lens.gain(60, 50).unwrap() - 1.0).abs() < 0.02);
        let want = 1.0 / (1.0 - 0.5 * (30.5f64.hypot(0.5) * 90.0 / 40.0) / 90.0);
        assert!((lens.gain(90, 50).unwrap() - want).abs() < 1e-9);
    }

    #[test]
    fn radius_and_polynomial_agree() {
        let table = "[vignetting]\nradius = [[0, 1], [1, 0.5]]\n";
        let formula = "rect = [1, 2, 30, 20]\n[vignetting]\npolynomial = [1, -0.5]\n";
        let (a, b) = (Description::parse(table).unwrap(), Description::parse(formula).unwrap());
        let (a, b) = (a.fit(40, 30).unwrap(), b.fit(40, 30).unwrap());
        assert_eq!((b.part, b.view_line.clone()), ([1, 2, 30, 20], None));
        for (x, y) in [(0, 0), (20, 15), (39, 3)] {
            assert!((a.gain(x, y).unwrap() - b.gain(x, y).unwrap()).abs() < 1e-12);
        }
        let corner = (19.5f64.hypot(14.5)) / 25.0;
        assert!((a.gain(0, 0).unwrap() - 1.0 / (1.0 - 0.5 * corner)).abs() < 1e-12);
    }

    #[test]
    fn views_of_square_pixels() {
        let line = |kind: &str, fov: f64| {
            let text = format!("projection = '{kind}'\nfov_deg = {fov}\n");
            Description::parse(&text).unwrap().fit(200, 100).unwrap().view_line.unwrap()
        };
        assert_eq!(line("perspective", 90.0), "VIEW= -vtv -vh 90 -vv 53.130102354");
        assert_eq!(line("fisheye", 180.0), "VIEW= -vta -vh 180 -vv 90");
        assert_eq!(line("hemispherical", 180.0), "VIEW= -vth -vh 180 -vv 60");
        let whole = Description::parse("projection = 'panorama'").unwrap().fit(200, 100).unwrap();
        assert_eq!(whole.view_line.as_deref(), Some("PROJECTION=latlong"));
    }

    #[test]
    fn what_cannot_be_is_named() {
        for (text, word) in [
            ("projection = 'fishy'", "fisheye"),
            ("projection = 'fisheye'", "fov_deg"),
            ("circle = [1, 1, 0]", "radius"),
            ("rect = [0, 0, 1, 0]", "rect"),
            ("density = -1", "density"),
            ("transmittance = [1, 0, 1]", "transmittance"),
            ("[vignetting]\npolynomial = [1, -2]", "polynomial"),
            ("[vignetting]\nradius = [[1, 1], [0, 1]]", "radius"),
            ("[vignetting]\nangle_deg = [[0, 1]]", "projection"),
            ("vigneting = 3", "vigneting"),
        ] {
            let message = Description::parse(text).unwrap_err().to_string();
            assert!(message.contains(word) && message.starts_with("line "), "{text}: {message}");
        }
        let beyond = Description::parse("circle = [10, 10, 11]").unwrap().fit(40, 40).unwrap_err();
        assert!(beyond.to_string().contains("40 x 40"));
    }
}
