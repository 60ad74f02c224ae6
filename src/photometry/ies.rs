//! Luminaire photometry in IES files (ANSI/IES LM-63 of 1986, 1991, 1995, 2002 and 2019).
//!
//! A file is lines of text and keywords, a `TILT=` line, then numbers apart by blanks or commas, in lines as they please:
//!
//! | numbers | are |
//! |---|---|
//! | lamps, lumens a lamp | -1 lumens: absolute photometry. Neither changes the intensities, which are those of that lamp |
//! | multiplier | of all intensities |
//! | vertical, horizontal angles | how many there are |
//! | photometric type | 1: C. 2 (B) and 3 (A) are refused |
//! | units, width, length, height | 1 feet, 2 metres; of the luminous opening, negative for round ones |
//! | ballast factor | multiplies too |
//! | one more | 1986 and 1991: ballast-lamp factor, multiplies; 1995 and 2002: reserved; 2019: how the file was made |
//! | input watts | |
//! | vertical angles | 0 is straight down, 180 up; from 0 or 90 to 90 or 180; there is no light beyond them |
//! | horizontal angles | 0: the same all round; 0 to 90: four quadrants alike; 0 to 180 and 90 to 270: two halves alike; 0 to 360 |
//! | intensities | candela, all vertical angles of the first horizontal angle, then of the next |
//!
//! The luminaire's frame: straight down is -z, horizontal angle 0 is +x (the opening's length lies along it), and 90 is +y:
//! counter-clockwise seen from above. Between the angles intensity is bilinear in the angles.
//!
//! `TILT=INCLUDE` gives factors for a lamp that dims as it is tipped over: they are kept ([`Tilt`]), and applied by whoever
//! hangs the luminaire; `TILT=name` is a file apart and refused.

use crate::error::printable;
use crate::{Error, Result, invalid};

mod numbers;

use numbers::Numbers;

/// Most intensities that a file may have.
const MOST: usize = 4_000_000;
const METRES_A_FOOT: f64 = 0.3048;

/// Which edition of LM-63 a file says it follows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Edition {
    /// No mark: LM-63-1986.
    Y1986,
    /// `IESNA91`
    Y1991,
    /// `IESNA:LM-63-1995`
    Y1995,
    /// `IESNA:LM-63-2002`
    Y2002,
    /// `IES:LM-63-2019`
    Y2019,
}

/// Factors of intensity for the angle by which a lamp is tipped from its position in the test.
#[derive(Clone, Debug, PartialEq)]
pub struct Tilt {
    /// Lamp to luminaire geometry: 1 base up or down with the luminaire aimed down, 2 and 3 lamp horizontal.
    pub geometry: u32,
    /// (angle in degrees, factor), angles ascending.
    pub factors: Vec<(f64, f64)>,
}

impl Tilt {
    /// The factor at an angle in degrees, linear between the points and constant beyond them.
    pub fn factor(&self, degrees: f64) -> f64 {
        let (i, t) = place(&self.factors, |p| p.0, degrees);
        let next = self.factors.get(i + 1).unwrap_or(&self.factors[i]);
        self.factors[i].1 + t * (next.1 - self.factors[i].1)
    }
}

/// What a file says of a luminaire.
#[derive(Clone, Debug, PartialEq)]
pub struct Photometry {
    /// Edition of the format.
    pub edition: Edition,
    /// Lines of the form `[NAME] text` in order, continued ones (`[MORE]`) joined by a blank; lines of another form have no name.
    pub keywords: Vec<(String, String)>,
    /// Number of lamps and lumens of each; `None` for absolute photometry.
    pub lamps: Option<(f64, f64)>,
    /// Width (along y), length (along x), height of the luminous opening, metres; negative where LM-63 means a round one.
    pub opening_m: [f64; 3],
    /// Electrical power, W.
    pub watts: f64,
    /// Factors for a tipped lamp.
    pub tilt: Option<Tilt>,
    vertical_deg: Vec<f64>,
    horizontal_deg: Vec<f64>,
    /// Candela, all factors applied, vertical angles running fastest.
    candela: Vec<f64>,
}

impl Photometry {
    /// Reads a file's bytes; errors name the line. Text in any encoding that has ASCII in it.
    ///
    /// ```
    /// use luxpipe::photometry::ies::Photometry;
    /// let file = "IESNA:LM-63-2002\n[TEST] sphere\nTILT=NONE\n1 1000 1 2 1 1 2 0 0 0\n1 1 10\n0 180\n0\n79.577 79.577\n";
    /// let lamp = Photometry::parse(file.as_bytes()).unwrap();
    /// assert!((lamp.flux_lm() - 1000.0).abs() < 0.01);
    /// assert!((lamp.intensity([0.0, 0.6, -0.8]) / 9.0 - 8.842).abs() < 1e-3); // lux at 3 m
    /// ```
    pub fn parse(bytes: &[u8]) -> Result<Photometry> {
        let text = String::from_utf8_lossy(bytes);
        let (edition, keywords, tilt_line, tilt) = label(&text)?;
        let mut numbers = Numbers::after(&text, tilt_line);
        let tilt = if tilt { Some(read_tilt(&mut numbers)?) } else { None };
        let mut photometry = read_body(&mut numbers, edition)?;
        numbers.end()?;
        (photometry.keywords, photometry.tilt) = (keywords, tilt);
        Ok(photometry)
    }

    /// The first keyword of that name.
    pub fn keyword(&self, name: &str) -> Option<&str> {
        self.keywords.iter().find(|k| k.0.eq_ignore_ascii_case(name)).map(|k| k.1.as_str())
    }

    /// Intensity in candela in a direction of the luminaire's frame, of any length.
    pub fn intensity(&self, direction: [f64; 3]) -> f64 {
        let [x, y, z] = direction;
        self.at(x.hypot(y).atan2(-z).to_degrees(), y.atan2(x).to_degrees())
    }

    /// Intensity in candela at a vertical angle of 0 (down) to 180 and any horizontal angle, degrees.
    pub fn at(&self, vertical_deg: f64, horizontal_deg: f64) -> f64 {
        let (first, last) = (self.vertical_deg[0], self.vertical_deg[self.vertical_deg.len() - 1]);
        if !(vertical_deg >= first && vertical_deg <= last) {
            return 0.0;
        }
        let (i, s) = place(&self.vertical_deg, |v| *v, vertical_deg);
        let (j, t) = place(&self.horizontal_deg, |h| *h, self.fold(horizontal_deg));
        let plane = |j: usize| {
            let row = &self.candela[j * self.vertical_deg.len()..];
            row[i] + s * (row[i + 1] - row[i])
        };
        if t > 0.0 { plane(j) + t * (plane(j + 1) - plane(j)) } else { plane(j) }
    }

    /// A horizontal angle as the one measured that is alike.
    fn fold(&self, degrees: f64) -> f64 {
        let around = degrees.rem_euclid(360.0);
        let mirrored = if around > 180.0 { 360.0 - around } else { around };
        match (self.horizontal_deg[0], self.horizontal_deg[self.horizontal_deg.len() - 1]) {
            (_, 0.0) => 0.0,
            (90.0, _) if around < 90.0 => 180.0 - around,
            (90.0, _) if around > 270.0 => 540.0 - around,
            (_, 90.0) if mirrored > 90.0 => 180.0 - mirrored,
            (_, 90.0 | 180.0) => mirrored,
            _ => around,
        }
    }

    /// Luminous flux in lumens: the exact integral over the sphere of what [`Photometry::at`] gives.
    pub fn flux_lm(&self) -> f64 {
        let horizontal = &self.horizontal_deg;
        let planes: Vec<f64> =
            self.candela.chunks(self.vertical_deg.len()).map(|p| zonal(&self.vertical_deg, p)).collect();
        if planes.len() == 1 {
            return std::f64::consts::TAU * planes[0];
        }
        let span = horizontal[horizontal.len() - 1] - horizontal[0];
        let steps = horizontal.windows(2).zip(planes.windows(2));
        let measured: f64 = steps.map(|(h, p)| 0.5 * (p[0] + p[1]) * (h[1] - h[0]).to_radians()).sum();
        measured * 360.0 / span
    }

    /// The largest measured intensity, candela.
    pub fn peak(&self) -> f64 {
        self.candela.iter().copied().fold(0.0, f64::max)
    }
}

/// Integral of a plane's intensity times the sine of the vertical angle; linear between the angles.
fn zonal(vertical_deg: &[f64], candela: &[f64]) -> f64 {
    let piece = |(v, i): (&[f64], &[f64])| {
        let (a, b) = (v[0].to_radians(), v[1].to_radians());
        let all = a.cos() - b.cos();
        let upper = (b.sin() - a.sin()) / (b - a) - b.cos(); // of (t - a) / (b - a)
        i[0] * (all - upper) + i[1] * upper
    };
    vertical_deg.windows(2).zip(candela.windows(2)).map(piece).sum()
}

/// Where x lies among ascending points: the interval's index, at most the last but one, and the share along it, 0 to 1.
fn place<T>(points: &[T], key: impl Fn(&T) -> f64, x: f64) -> (usize, f64) {
    let above = points.partition_point(|p| key(p) <= x);
    let i = above.saturating_sub(1).min(points.len().saturating_sub(2));
    let Some(next) = points.get(i + 1) else { return (i, 0.0) };
    let (a, b) = (key(&points[i]), key(next));
    (i, ((x - a) / (b - a)).clamp(0.0, 1.0))
}

/// The lines up to TILT: edition, keywords, that line's number from 0, whether factors follow it.
type Label = (Edition, Vec<(String, String)>, usize, bool);

fn label(text: &str) -> Result<Label> {
    let mut edition = Edition::Y1986;
    let mut keywords: Vec<(String, String)> = Vec::new();
    for (n, line) in text.lines().enumerate() {
        let line = line.trim();
        if let Some((_, tilt)) = line.split_once('=').filter(|p| p.0.trim().eq_ignore_ascii_case("TILT")) {
            return match tilt.trim() {
                none if none.eq_ignore_ascii_case("NONE") => Ok((edition, keywords, n, false)),
                here if here.eq_ignore_ascii_case("INCLUDE") => Ok((edition, keywords, n, true)),
                file => Err(Error::Unsupported(format!(
                    "line {}: tilt factors in another file, '{}': put them into this one after TILT=INCLUDE",
                    n + 1,
                    printable(file.as_bytes())
                ))),
            };
        }
        if n == 0 && line.to_ascii_uppercase().starts_with("IES") {
            match edition_of(line)? {
                Some(known) => {
                    edition = known;
                    continue;
                }
                None => edition = Edition::Y1986,
            }
        }
        let named = line.strip_prefix('[').and_then(|rest| rest.split_once(']'));
        match (named, keywords.last_mut()) {
            (Some(("MORE", more)), Some(last)) => {
                last.1.push(' ');
                last.1.push_str(more.trim());
            }
            (Some((name, value)), _) => keywords.push((name.to_string(), value.trim().to_string())),
            (None, _) if line.is_empty() => {}
            (None, _) => keywords.push((String::new(), line.to_string())),
        }
    }
    invalid!("no line TILT=NONE or TILT=INCLUDE; is this an IES file?")
}

/// The edition that a first line names; `None` where it is only a label, an error for an edition unheard of.
fn edition_of(line: &str) -> Result<Option<Edition>> {
    let upper = line.to_ascii_uppercase();
    let year = upper.strip_prefix("IESNA:LM-63-").or_else(|| upper.strip_prefix("IES:LM-63-"));
    match (upper.as_str(), year.map(str::trim)) {
        ("IESNA91", _) | (_, Some("1991")) => Ok(Some(Edition::Y1991)),
        (_, Some("1986")) => Ok(Some(Edition::Y1986)),
        (_, Some("1995")) => Ok(Some(Edition::Y1995)),
        (_, Some("2002")) => Ok(Some(Edition::Y2002)),
        (_, Some("2019")) => Ok(Some(Edition::Y2019)),
        (_, Some(_)) => Err(Error::Unsupported(format!(
            "line 1: '{}': the editions known are those of 1986, 1991, 1995, 2002 and 2019",
            printable(line.as_bytes())
        ))),
        (_, None) => Ok(None),
    }
}

fn read_tilt(numbers: &mut Numbers) -> Result<Tilt> {
    let geometry = numbers.count("the lamp to luminaire geometry", 1, 3)? as u32;
    let n = numbers.count("the number of tilt angles", 1, 10_000)?;
    let angles = numbers.ascending("tilt angle", n)?;
    let factors = numbers.many("tilt factor", n, 0.0..=1e3)?;
    Ok(Tilt { geometry, factors: angles.into_iter().zip(factors).collect() })
}

/// The numbers after the tilt factors.
fn read_body(numbers: &mut Numbers, edition: Edition) -> Result<Photometry> {
    let lamps = numbers.within("the number of lamps", 0.0..=1e6)?;
    let lumens = numbers.within("the lumens a lamp", -1.0..=1e12)?;
    let multiplier = numbers.within("the multiplier", 0.0..=1e9)?;
    let rows = numbers.count("the number of vertical angles", 2, MOST)?;
    let planes = numbers.count("the number of horizontal angles", 1, MOST)?;
    if rows.saturating_mul(planes) > MOST {
        return numbers.refuse(&format!("{rows} x {planes} intensities; {MOST} are the most"));
    }
    let kind = numbers.count("the photometric type", 1, 3)?;
    if kind != 1 {
        let name = if kind == 2 { "B" } else { "A" };
        return Err(Error::Unsupported(format!(
            "line {}: photometry of type {name} ({kind}); only type C (1) is read",
            numbers.line()
        )));
    }
    let metres = if numbers.count("the unit (1 feet, 2 metres)", 1, 2)? == 1 { METRES_A_FOOT } else { 1.0 };
    let opening = numbers.many("dimension", 3, -1e6..=1e6)?;
    let ballast = numbers.within("the ballast factor", 0.0..=1e6)?;
    let second = numbers.within("the ballast-lamp factor", -1e9..=1e9)?;
    let watts = numbers.within("the input watts", 0.0..=1e12)?;
    let mut factor = multiplier * ballast;
    if edition <= Edition::Y1991 {
        if second < 0.0 {
            return numbers.refuse(&format!("the ballast-lamp factor is {second}; it must not be negative"));
        }
        factor *= second;
    }
    let vertical_deg = numbers.ascending("vertical angle", rows)?;
    let ends = (vertical_deg[0], vertical_deg[rows - 1]);
    if !matches!(ends, (0.0, 90.0 | 180.0) | (90.0, 180.0)) {
        return numbers
            .refuse(&format!("vertical angles from {} to {}; 0 to 90, 0 to 180 or 90 to 180", ends.0, ends.1));
    }
    let horizontal_deg = numbers.ascending("horizontal angle", planes)?;
    let ends = (horizontal_deg[0], horizontal_deg[planes - 1]);
    if !matches!(ends, (0.0, 0.0 | 90.0 | 180.0 | 360.0) | (90.0, 270.0)) {
        let right = "0, 0 to 90, 0 to 180, 0 to 360 or 90 to 270";
        return numbers.refuse(&format!("horizontal angles from {} to {}; {right}", ends.0, ends.1));
    }
    let mut candela = numbers.many("intensity", rows * planes, 0.0..=1e12)?;
    candela.iter_mut().for_each(|c| *c *= factor);
    Ok(Photometry {
        edition,
        keywords: Vec::new(),
        lamps: (lumens >= 0.0).then_some((lamps, lumens)),
        opening_m: std::array::from_fn(|i| opening[i] * metres),
        watts,
        tilt: None,
        vertical_deg,
        horizontal_deg,
        candela,
    })
}

#[cfg(test)]
mod tests;
