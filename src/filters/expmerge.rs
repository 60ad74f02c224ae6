//! expmerge: bracketed exposures to one picture of light; [`crate::capture`] tells how.

use std::io::Write as _;
use std::path::{Path, PathBuf};

use clap::{Args, ValueHint};
use serde::{Deserialize, Serialize};

use crate::capture::curve::{Choice, Curves};
use crate::capture::exposure::{Amounts, Settings, hdrgen_list, state};
use crate::capture::lens::{Description, Lens};
use crate::capture::merge::{Colours, Merge};
use crate::capture::picture::Merged;
use crate::capture::spot::{Spot, factor, mean_of};
use crate::capture::{Bracket, chart, read_all};
use crate::color::{Primaries, Xy};
use crate::filter::{Filter, Product, Run};
use crate::options::Range;
use crate::stream::output::Output;
use crate::stream::{Components, Header, Picture, Resolution, Units};
use crate::{Error, Result, clap_defaults, files, invalid, usage};

/// Options of `expmerge`.
#[derive(Args, Clone, Debug, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields, rename_all = "kebab-case")]
pub struct Expmerge {
    /// Exposures of one scene from one place: JPEG, PNG or TIFF files of 8 or 16 bits, in any order
    #[arg(value_name = "EXPOSURE", value_hint = ValueHint::FilePath)]
    pub exposures: Vec<PathBuf>,
    /// Take the exposures and their settings from a list as pfstools' jpeg2hdrgen prints it: file, 1/seconds, f-number, ISO, density
    #[arg(long, value_name = "LIST", value_hint = ValueHint::FilePath, conflicts_with_all = ["exposures", "times", "aperture", "iso"])]
    pub hdrgen: Option<PathBuf>,
    /// Exposure times in seconds, one for each file, such as 1/250,1/60,1/15,0.25; EXIF's otherwise
    #[arg(long, value_name = "LIST")]
    pub times: Option<Amounts>,
    /// f-numbers, one for all or one for each file; EXIF's otherwise
    #[arg(long, value_name = "LIST")]
    pub aperture: Option<Amounts>,
    /// ISO speeds, one for all or one for each file; EXIF's otherwise
    #[arg(long, value_name = "LIST")]
    pub iso: Option<Amounts>,
    /// Take the response as known: srgb, linear, gamma2.2 or the like, or a file that --response has printed; recovered otherwise
    #[arg(long, value_name = "RESPONSE", value_hint = ValueHint::FilePath)]
    pub curve: Option<Choice>,
    /// Print the response g(z) instead of a picture: a line a code with g of red, green and blue, for --curve
    #[arg(long, conflicts_with_all = ["mask", "spot", "scale", "lens", "camera", "chart"])]
    pub response: bool,
    /// Smoothness of the recovered response: more for steps of several stops and noise, less for curves far from sRGB's
    #[arg(long, value_name = "LAMBDA", default_value_t = 10.0, conflicts_with = "curve")]
    pub smooth: f64,
    /// About how many pixels the response is recovered from
    #[arg(long, value_name = "N", default_value_t = 2000, conflicts_with = "curve")]
    pub pixels: usize,
    /// Codes that count, as shares of the largest: from black and noise to clipped white
    #[arg(long, value_name = "LOW:HIGH", default_value = "0.008:0.98")]
    pub range: Range,
    /// Lens: vignetting, projection, the part that counts, a neutral filter (docs/capture.md)
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub lens: Option<PathBuf>,
    /// Primaries that the camera's pictures have
    #[arg(long, value_name = "PRIMARIES", default_value = "BT.709", conflicts_with_all = ["camera", "chart"])]
    pub primaries: Primaries,
    /// Matrix from the camera's linear channels to XYZ: a text of three rows of three numbers
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath, conflicts_with = "chart")]
    pub camera: Option<PathBuf>,
    /// Fit that matrix to a chart in the picture: TOML with rectangles and their colours (docs/capture.md)
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub chart: Option<PathBuf>,
    /// Write the matrix of --chart for --camera of other brackets
    #[arg(long, value_name = "FILE", value_hint = ValueHint::AnyPath, requires = "chart")]
    pub save_camera: Option<PathBuf>,
    /// Luminance that was measured, which makes the picture absolute; once for each spot
    #[arg(long, value_name = "X,Y[,R]=CD_M2", conflicts_with = "scale")]
    pub spot: Vec<Spot>,
    /// Factor that an earlier bracket's --spot has given (CALIBRATION in its header), which makes the picture absolute
    #[arg(long, value_name = "FACTOR")]
    pub scale: Option<f64>,
    /// Write a mask as PNG: 255 where some channel is white in every exposure, 128 where all are black, 0 elsewhere
    #[arg(long, value_name = "FILE", value_hint = ValueHint::AnyPath)]
    pub mask: Option<PathBuf>,
}
clap_defaults!(Expmerge);

impl Filter for Expmerge {
    const NAME: &'static str = "expmerge";
    const ABOUT: &'static str =
        "Merge bracketed exposures to one picture of light, absolute where a luminance is known";
    const EXAMPLE: &'static str = "expmerge --times 1/60,1/8,1 tests/data/capture/short.png tests/data/capture/middle.png tests/data/capture/long.png > room.lux
expmerge --response tests/data/capture/a.jpg tests/data/capture/b.jpg tests/data/capture/c.jpg > camera.txt
expmerge --curve camera.txt --spot 12,8=250 tests/data/capture/a.jpg tests/data/capture/b.jpg tests/data/capture/c.jpg > room.lux";
    const READS: bool = false;
    const MANY: bool = true;

    fn look_ahead(&self) -> Result<Option<usize>> {
        if let Some(path) = &self.hdrgen {
            for (shot, _) in listed(path)? {
                files::open(&shot).map_err(|e| Error::io(shot.display().to_string(), e))?;
            }
        }
        Ok(None)
    }

    fn start(self, _: Option<Box<dyn Picture>>, run: &Run) -> Result<Product> {
        self.check_options()?;
        let bracket = self.bracket()?;
        let range = (self.range.0, self.range.1);
        bracket.check_light(range)?;
        let (curves, how) = match &self.curve {
            Some(choice) => (Curves::of(choice)?, format!("response {}", last_part(choice))),
            None => {
                let (curves, how) = bracket.recover(self.pixels, self.smooth, &run.notes)?;
                (curves, format!("response {how}"))
            }
        };
        if self.response {
            return Ok(printed(&curves, bracket.nodes(), &how));
        }
        let capture = captured(&bracket, &how);
        let (nominal, Bracket { shots, exposures, .. }) = (bracket.exposures.nominal, bracket);
        let lens = self.lens(shots.first().map_or((0, 0), |s| (s.width, s.height)))?;
        let merge = Merge::new(shots, &exposures.amounts, &curves, range, lens);
        let colouring = self.colours(&merge, run)?;
        let (scale, calibration) = self.calibration(&merge, &colouring, nominal, run)?;
        let header = self.header(&merge, &colouring, [capture, calibration], run);
        let notes = run.notes.clone();
        Ok(Product::Picture(Box::new(Merged::new(header, merge, colouring.colours, scale, self.mask, notes))))
    }
}

/// What the channels are.
struct Colouring {
    colours: Colours,
    /// A matrix of an absolute chart makes cd/m2.
    absolute: bool,
    white: Option<Xy>,
}

impl Expmerge {
    fn check_options(&self) -> Result<()> {
        if !(self.smooth > 0.0 && self.smooth <= 1e4) {
            return usage!("--smooth {} must be above 0 and at most 10000", self.smooth);
        }
        if !(50..=200_000).contains(&self.pixels) {
            return usage!("--pixels {} must be 50 to 200000", self.pixels);
        }
        if self.range.0 < 0.0 || self.range.1 > 1.0 {
            return usage!("--range {}: codes are shares, 0 to 1", self.range);
        }
        super::positive("--scale", self.scale)?;
        if self.exposures.is_empty() && self.hdrgen.is_none() {
            return usage!("expected EXPOSURE files, or a list by --hdrgen; see --help");
        }
        match self.exposures.iter().enumerate().find(|(i, b)| self.exposures[..*i].contains(b)) {
            Some((_, file)) => invalid!("{}: is named twice", file.display()),
            None => Ok(()),
        }
    }

    /// The exposures with what is known of them.
    fn bracket(&self) -> Result<Bracket> {
        if let Some(path) = &self.hdrgen {
            let (paths, settings): (Vec<PathBuf>, Vec<Settings>) = listed(path)?.into_iter().unzip();
            return Bracket::new(read_all(&paths)?, &settings);
        }
        let shots = read_all(&self.exposures)?;
        let mut settings: Vec<Settings> = shots.iter().map(|s| s.settings).collect();
        state(self.times.as_ref(), "--times", false, &mut settings, |s, x| s.seconds = Some(x))?;
        state(self.aperture.as_ref(), "--aperture", true, &mut settings, |s, x| s.f_number = Some(x))?;
        state(self.iso.as_ref(), "--iso", true, &mut settings, |s, x| s.iso = Some(x))?;
        Bracket::new(shots, &settings)
    }

    fn lens(&self, (width, height): (usize, usize)) -> Result<Lens> {
        let Some(path) = &self.lens else { return Ok(Lens::none(width, height)) };
        let lens = Description::parse(&text(path)?).and_then(|d| d.fit(width, height));
        lens.map_err(|e| e.in_file(path))
    }

    fn colours(&self, merge: &Merge, run: &Run) -> Result<Colouring> {
        let (matrix, absolute, white) = if let Some(path) = &self.camera {
            (chart::parse_matrix(&text(path)?).map_err(|e| e.in_file(path))?, false, None)
        } else if let Some(path) = &self.chart {
            let folder = path.parent().unwrap_or(Path::new(""));
            let fitted = || {
                let chart = chart::parse(&text(path)?, folder)?;
                let patch = |(i, p): (usize, &chart::Patch)| {
                    mean_of(merge, p.rect).map_err(|e| e.within(&format!("patch {}", i + 1)))
                };
                let channels = chart.patches.iter().enumerate().map(patch).collect::<Result<Vec<_>>>()?;
                Ok((chart::fit(&chart, &channels)?, chart))
            };
            let (fit, chart) = fitted().map_err(|e: Error| e.in_file(path))?;
            let (mean, most, worst) = fit.errors;
            run.notes.add(format!("chart: CIEDE2000 {mean:.2} in the mean, {most:.2} at most (patch {worst})"));
            if let Some(path) = &self.save_camera {
                save_matrix(path, &fit.matrix, chart.absolute)?;
            }
            (fit.matrix, chart.absolute, chart.white.map(|w| w.0))
        } else {
            let to_xyz = self
                .primaries
                .to_xyz()
                .ok_or_else(|| Error::Usage(format!("--primaries {}: span no area", self.primaries)))?;
            let colours = Colours { matrix: None, luminance: to_xyz.0[1] };
            return Ok(Colouring { colours, absolute: false, white: Some(self.primaries.white) });
        };
        Ok(Colouring { colours: Colours { matrix: Some(matrix), luminance: matrix.0[1] }, absolute, white })
    }

    /// The factor of the picture's light, and what the header says of it.
    fn calibration(&self, merge: &Merge, c: &Colouring, nominal: bool, run: &Run) -> Result<(f64, String)> {
        if !self.spot.is_empty() {
            let (factor, spread) = factor(merge, &c.colours, &self.spot)?;
            let percent = 100.0 * (spread - 1.0);
            if percent > 10.0 {
                run.notes.add(format!("the spots disagree by up to {percent:.0} % from their mean"));
            }
            return Ok((factor, format!("spot, factor {factor:.6e}, spots within {percent:.1} %")));
        }
        if let Some(factor) = self.scale {
            return Ok((factor, format!("scale, factor {factor:e}")));
        }
        Ok((
            1.0,
            match (c.absolute, nominal) {
                (true, _) => "chart".into(),
                (false, true) => {
                    "none; nominal cd/m2 by time, f-number and ISO speed, right within a stop or so".into()
                }
                (false, false) => "none; relative to white in an exposure of 1 s".into(),
            },
        ))
    }

    fn header(&self, merge: &Merge, c: &Colouring, [capture, calibration]: [String; 2], run: &Run) -> Header {
        let known = c.absolute || self.scale.is_some() || !self.spot.is_empty();
        let [.., width, height] = merge.lens.part;
        let components = if c.colours.matrix.is_some() { Components::Xyz } else { Components::Rgb };
        let units = if known { Units::CdM2 } else { Units::Relative };
        let mut header = Header::new(Resolution::upright(width, height), components, 3, units);
        header.primaries = c.colours.matrix.is_none().then_some(self.primaries);
        header.white = c.white;
        header.lines.push(run.history.clone());
        header.lines.extend(merge.lens.view_line.iter().map(|l| l.clone().into_bytes()));
        header.lines.push(format!("CAPTURE= {capture}").into_bytes());
        header.lines.push(format!("CALIBRATION= {calibration}").into_bytes());
        header
    }
}

/// The bracket in words, for the header.
fn captured(bracket: &Bracket, how: &str) -> String {
    let (short, long) = bracket.seconds;
    format!("{} exposures of {short:.4e} to {long:.4e} s, {how}", bracket.shots.len())
}

fn last_part(choice: &Choice) -> String {
    match choice {
        Choice::File(path) => crate::error::printable(path.file_name().unwrap_or_default().as_encoded_bytes()),
        known => known.to_string(),
    }
}

fn listed(path: &Path) -> Result<Vec<(PathBuf, Settings)>> {
    hdrgen_list(&text(path)?, path.parent().unwrap_or(Path::new(""))).map_err(|e| e.in_file(path))
}

fn text(path: &Path) -> Result<String> {
    files::read_to_string(path).map_err(|e| Error::io(path.display().to_string(), e))
}

/// The response as a text.
fn printed(curves: &Curves, nodes: usize, how: &str) -> Product {
    let text = format!(
        "# expmerge --response: g(z), the natural logarithm of light by code, 0 at the middle one; {how}\n# code\tred\tgreen\tblue\n{}",
        curves.to_text(nodes)
    );
    let write = move |out: &mut Output| out.write_all(text.as_bytes()).map_err(|e| out.error(e));
    Product::Bytes { binary: false, write: Box::new(write) }
}

fn save_matrix(path: &Path, matrix: &crate::color::Mat3, absolute: bool) -> Result<()> {
    // Another bracket's scale is its own: what is kept has Y = 1 for white.
    let y = if absolute { matrix.apply([1.0; 3])[1] } else { 1.0 };
    let mut out = Output::create(Some(path), false)?;
    let text = format!("# expmerge --chart: camera RGB to XYZ\n{}", chart::matrix_text(&matrix.scaled(1.0 / y)));
    out.write_all(text.as_bytes()).map_err(|e| out.error(e))?;
    out.finish()
}
