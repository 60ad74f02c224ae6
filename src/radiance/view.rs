//! Views in Radiance's words, from `.vf` files or a command line, and the camera that each is.
//!
//! | option | is |
//! |---|---|
//! | `-vtv -vtl -vta -vth -vts -vtc` | perspective, parallel, angular, hemispherical, planispheric, cylinder |
//! | `-vp x y z`, `-vd x y z`, `-vu x y z` | eye, line of sight, up |
//! | `-vh`, `-vv` | degrees across and up, lengths of a parallel view |
//! | `-vs`, `-vl`, `-vo`, `-va` | shift, lift, clipping: only 0 |

use glam::DVec3;

use crate::radiance::write::{list, number};
use crate::{Result, invalid};

/// A view.
#[derive(Clone, Debug, PartialEq)]
pub struct View {
    kind: char,
    eye: DVec3,
    toward: DVec3,
    up: DVec3,
    /// Across and up.
    angles: [f64; 2],
}

impl Default for View {
    /// Radiance's: from the origin along y, 45 degrees.
    fn default() -> View {
        View { kind: 'v', eye: DVec3::ZERO, toward: DVec3::Y, up: DVec3::Z, angles: [45.0; 2] }
    }
}

/// Options with a number that a camera here has no word for.
const ZERO: [&str; 4] = ["-vs", "-vl", "-vo", "-va"];

impl View {
    /// Takes a file's lines, each on top of those before: a program's name or `VIEW=`, and options. Errors name the line.
    pub fn read(&mut self, text: &str) -> Result<()> {
        let mut found = false;
        for (i, line) in text.lines().enumerate() {
            let words: Vec<&str> = line.split_ascii_whitespace().collect();
            let Some(first) = words.iter().position(|w| w.starts_with("-v")) else { continue };
            if line.trim_start().starts_with('#') || first > 1 {
                continue;
            }
            self.options(&words[first..]).map_err(|e| e.within(&format!("line {}", i + 1)))?;
            found = true;
        }
        if found {
            Ok(())
        } else {
            invalid!("line 1: no view; expected a line such as 'rvu -vtv -vp 0 0 0 -vd 0 1 0 -vh 45 -vv 45'")
        }
    }

    /// Takes options.
    ///
    /// ```
    /// use luxpipe::radiance::view::View;
    /// let mut view = View::default();
    /// view.options(&["-vtl", "-vp", "1", "2", "3", "-vh", "4"]).unwrap();
    /// assert!(view.options(&["-vp", "1"]).unwrap_err().to_string().contains("-vp"));
    /// ```
    pub fn options(&mut self, words: &[&str]) -> Result<()> {
        let mut rest = words;
        while let Some((option, after)) = rest.split_first() {
            let numbers = |n: usize| -> Result<Vec<f64>> {
                let list: Vec<f64> =
                    after.iter().take(n).map_while(|w| w.parse().ok()).filter(|x: &f64| x.is_finite()).collect();
                if list.len() == n { Ok(list) } else { invalid!("{option}: expected {n} numbers") }
            };
            let used = match *option {
                "-vp" | "-vd" | "-vu" => {
                    let v = DVec3::from_slice(&numbers(3)?);
                    match *option {
                        "-vp" => self.eye = v,
                        "-vd" => self.toward = v,
                        _ => self.up = v,
                    }
                    3
                }
                "-vh" => {
                    self.angles[0] = numbers(1)?[0];
                    1
                }
                "-vv" => {
                    self.angles[1] = numbers(1)?[0];
                    1
                }
                zero if ZERO.contains(&zero) => {
                    if numbers(1)?[0] != 0.0 {
                        return invalid!("{option} {}: shifted and clipped views are not read; expected 0", after[0]);
                    }
                    1
                }
                kind => {
                    let letter = kind.strip_prefix("-vt").filter(|k| k.len() == 1).and_then(|k| k.chars().next());
                    match letter.filter(|c| "vlahsc".contains(*c)) {
                        Some(letter) => self.kind = letter,
                        None => {
                            let shown = crate::error::printable(kind.as_bytes());
                            return invalid!(
                                "'{shown}' is no option of a view; expected -vtv, -vtl, -vta, -vth, -vts, -vtc, -vp, -vd, -vu, -vh, -vv"
                            );
                        }
                    }
                    0
                }
            };
            rest = &after[used..];
        }
        Ok(())
    }

    /// Height over width.
    fn aspect(&self) -> f64 {
        let of = |f: fn(f64) -> f64, share: f64| {
            let [h, v] = self.angles.map(|a| (a * share).to_radians());
            f(v) / f(h)
        };
        match self.kind {
            'v' => of(f64::tan, 0.5),
            'h' => of(f64::sin, 0.5),
            's' => of(f64::tan, 0.25),
            'c' => 2.0 * (self.angles[1] / 2.0).to_radians().tan() / self.angles[0].to_radians(),
            _ => self.angles[1] / self.angles[0],
        }
    }

    /// The table of a camera whose square pixels fill at most this width and height, as `rpict -x -y` has it.
    pub fn toml(&self, (width, height): (usize, usize)) -> Result<String> {
        let [h, v] = self.angles;
        let aspect = self.aspect();
        let possible = match self.kind {
            'v' => h < 179.9 && v < 180.0,
            'c' => h <= 360.0 && v < 180.0,
            'h' => h <= 180.0 && v <= 180.0,
            'a' => h <= 360.0 && v <= 360.0,
            's' => h < 360.0 && v < 360.0,
            _ => true,
        };
        if !(possible && h > 0.0 && v > 0.0 && aspect.is_finite() && aspect > 0.0) {
            return invalid!("a view of {h} by {v} shows nothing; expected -vh and -vv above 0 that its type can have");
        }
        let (toward, up) = (self.toward.normalize_or_zero(), self.up.normalize_or_zero());
        if toward.cross(up).length() < 1e-9 {
            return invalid!("-vd and -vu must be directions, and not the same one");
        }
        let (w, t) = (width as f64, height as f64);
        let (width, height) =
            if t > aspect * w { (w, (aspect * w + 0.5).floor()) } else { ((t / aspect + 0.5).floor(), t) };
        let (kind, extent) = match self.kind {
            'v' => ("perspective", "fov_deg"),
            'l' => ("parallel", "width_seen"),
            'a' => ("fisheye", "fov_deg"),
            'h' => ("hemispherical", "fov_deg"),
            's' => ("planispheric", "fov_deg"),
            _ => ("cylinder", "fov_deg"),
        };
        let point = |p: DVec3| list(p.to_array());
        Ok(format!(
            "\n[camera]\ntype = \"{kind}\"\norigin = {}\ntarget = {}\nup = {}\n{extent} = {}\nwidth = {}\nheight = {}\n",
            point(self.eye),
            point(self.eye + toward),
            point(up),
            number(h),
            width.max(1.0),
            height.max(1.0)
        ))
    }
}
