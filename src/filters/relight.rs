//! relight: the layers of `spectrace --per-light` summed under the scene's lamps or others in their place.
//!
//! XYZ is linear in the lamps, so the sum is what rendering again on the same paths would give: exactly with full bands, and within the
//! tolerance of a plan's wavelengths, whose weights are worked out anew for the lamps that change. A new spectrum keeps the lamp's
//! luminance; the number after it dims.

use clap::{Args, ValueHint};
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

use crate::error::printable;
use crate::filter::{Filter, Product, Run};
use crate::options::lossy;
use crate::plan::Ladder;
use crate::plan::survey::Survey;
use crate::render::film::light_weights;
use crate::scene::{Scene, load};
use crate::spectral::key::SpectrumKey;
use crate::spectral::{Observer, Sampling, Spectrum};
use crate::stream::meaning::{LAYER, LAYERS_OF};
use crate::stream::tristimulus::integrated;
use crate::stream::{Components, Header, Picture, Units};
use crate::units::K_M;
use crate::{Error, Result, clap_defaults, invalid, usage};

/// Options of `relight`.
#[derive(Args, Clone, Debug, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields, rename_all = "kebab-case")]
pub struct Relight {
    /// Scene that the layers were rendered of (TOML): its lamps are those that stay
    #[arg(value_name = "SCENE", value_hint = ValueHint::FilePath, required = true)]
    #[serde(serialize_with = "lossy")]
    pub scene: Option<PathBuf>,
    /// Give a light another spectrum of the same luminance, dim it, or both: lamp=FL11, lamp=:0.4, lamp=FL11:0.4; once for each. What stands after the last colon is the factor
    #[arg(long, value_name = "LIGHT=[SPECTRUM][:FACTOR]")]
    pub set: Vec<String>,
    /// Lights without a --set are off
    #[arg(long)]
    pub only: bool,
}
clap_defaults!(Relight);

impl Filter for Relight {
    const NAME: &'static str = "relight";
    const ABOUT: &'static str = "Sum a render's layers of lights under other lamps: new spectra, dimming";
    const EXAMPLE: &'static str = "spectrace scenes/cornell.toml --width 128 --per-light > layers.lux && relight scenes/cornell.toml --set lamp=FL11:0.4 layers.lux > evening.lux";

    fn look_ahead(&self) -> Result<Option<usize>> {
        self.scene.as_deref().map(load::load).transpose().map(|_| None)
    }

    fn start(self, input: Option<Box<dyn Picture>>, run: &Run) -> Result<Product> {
        let input = input.ok_or_else(|| Error::Usage("expected the layers of spectrace --per-light".into()))?;
        let path = self.scene.as_deref().ok_or_else(|| Error::Usage("expected a scene file".into()))?;
        let header = input.header();
        if header.components != Components::Layers {
            return invalid!("expected the layers of spectrace --per-light, the picture is {}", header.components);
        }
        let Some(sampling) = header.sampling.clone() else { return invalid!("the layers list no wavelengths") };
        let mut scene = load::load(path)?;
        run.notes.extend(&scene.remarks);
        check(&scene, header, path)?;
        let factors = self.relit(&mut scene)?;
        let weights = weights(&scene, &sampling, run).map_err(|e| e.in_file(path))?;
        let dimmed = |c: usize| -> Vec<f64> {
            weights.iter().zip(&factors).flat_map(|(w, f)| w[c].iter().map(move |w| w * f)).collect()
        };
        let mut out = header.clone();
        out.become_tristimulus(Components::Xyz, Units::CdM2);
        out.lines.retain(|l| !l.starts_with(LAYER) && !l.starts_with(LAYERS_OF.as_bytes()));
        out.white = scene.dominant_dimmed(&factors)?.map(|d| d.1);
        Ok(Product::Picture(integrated(input, out, &[0, 1, 2].map(dimmed))?))
    }
}

/// The lights of the picture must be those of the scene.
fn check(scene: &Scene, header: &Header, path: &Path) -> Result<()> {
    let names = header.lines.iter().filter_map(|l| l.strip_prefix(LAYER)).map(|n| printable(n).trim().to_string());
    let own = scene.lights.iter().map(|l| printable(l.name.as_bytes()).trim().to_string());
    let other = header.variable(LAYERS_OF).is_some_and(|of| of != format!("{:016x}", scene.fingerprint()).as_bytes());
    if other || !names.eq(own) {
        return invalid!(
            "the layers are of other lights than those of {}",
            printable(path.as_os_str().as_encoded_bytes())
        );
    }
    Ok(())
}

impl Relight {
    /// Gives the scene its new spectra; what each light is dimmed by.
    fn relit(&self, scene: &mut Scene) -> Result<Vec<f64>> {
        let mut factors = vec![if self.only { 0.0 } else { 1.0 }; scene.lights.len()];
        let mut seen: Vec<&str> = Vec::new();
        for word in &self.set {
            let shown = printable(word.as_bytes());
            let Some((name, change)) = word.split_once('=') else {
                return usage!("--set {shown}: LIGHT=SPECTRUM, LIGHT=:FACTOR or LIGHT=SPECTRUM:FACTOR");
            };
            let of_name: Vec<usize> = (0..scene.lights.len()).filter(|i| scene.lights[*i].name == name).collect();
            if of_name.is_empty() {
                let names: Vec<String> = scene.lights.iter().map(|l| printable(l.name.as_bytes())).collect();
                return usage!("--set {shown}: the scene has no such light, but {}", names.join(", "));
            }
            if seen.contains(&name) {
                return usage!("--set {shown}: '{}' is set twice", printable(name.as_bytes()));
            }
            seen.push(name);
            let (spectrum, factor) = match change.rsplit_once(':') {
                Some((spectrum, factor)) => (spectrum, factor.parse::<f64>().ok()),
                None => (change, Some(1.0)),
            };
            let Some(factor) = factor.filter(|f| (0.0..=1e6).contains(f)) else {
                return usage!("--set {shown}: a factor of 0 to 1000000 stands after the last colon");
            };
            of_name.iter().for_each(|i| factors[*i] = factor);
            match (spectrum, &of_name[..]) {
                ("", _) => {}
                (_, [i]) => {
                    let new = spectrum.parse::<SpectrumKey>().and_then(|key| key.resolve(Path::new("")));
                    let new = new.map_err(|e| e.within(&format!("--set {shown}")))?;
                    let radiance = &mut scene.lights[*i].radiance;
                    *radiance = as_bright(&new, radiance).map_err(|e| e.within(&format!("--set {shown}")))?;
                }
                _ => return invalid!("--set {shown}: this light is a sum of several spectra; it can only be dimmed"),
            }
        }
        Ok(factors)
    }
}

/// A spectrum of the luminance that another has.
fn as_bright(new: &Spectrum, old: &Spectrum) -> Result<Spectrum> {
    let y = &Observer::cie1931()?.cmf[1];
    let luminance = |s: &Spectrum| s.product_integral(y, 0.0, f64::INFINITY);
    match (luminance(new), luminance(old)) {
        (n, o) if n > 0.0 && o > 0.0 => Ok(new.scaled(o / n)),
        (n, _) if n <= 0.0 => invalid!("the new spectrum cannot be seen: it has no luminance to be given"),
        _ => invalid!("a light that cannot be seen has no luminance to keep"),
    }
}

/// [light][X, Y, Z][wavelength].
fn weights(scene: &Scene, sampling: &Sampling, run: &Run) -> Result<Vec<[Vec<f64>; 3]>> {
    if let Sampling::Points(nm) = sampling {
        let survey = Survey::of(scene)?;
        if let Some(why) = &survey.needs_bands {
            return invalid!("a few wavelengths will not do: {why}; render the layers in full bands");
        }
        let rung = Ladder::new(&survey, 10.0).at(nm)?;
        run.notes.add(format!(
            "{} wavelengths under these lamps: colours within {:.3} Delta E 2000",
            nm.len(),
            rung.bound()
        ));
        return Ok(survey.scaled(&rung.rule).weights);
    }
    let cmf = Observer::cie1931()?.cmf.map(|c| c.scaled(K_M));
    let (a, b) = (sampling.edges(0), sampling.edges(sampling.count() - 1));
    let range_nm = (a.0.min(b.0), a.1.max(b.1));
    let of = |l: &crate::scene::Light| cmf.each_ref().map(|c| light_weights(&l.radiance, sampling, range_nm, c));
    Ok(scene.lights.iter().map(of).collect())
}
