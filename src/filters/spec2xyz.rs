//! spec2xyz: spectral radiance to tristimulus values, Eq. (4) of [Ward 2001], or to any weighted sum of wavelengths.

use clap::{Args, ValueEnum, ValueHint};
use serde::{Deserialize, Serialize};

use crate::clap_defaults;
use crate::color::Xy;
use crate::filter::{Filter, Product, Run};
use crate::spectral::{Observer, Sampling, Spectrum, builtin, text};
use crate::stream::tristimulus::{integrated, tristimulus, weights};
use crate::stream::{Components, Header, Picture, Units};
use crate::{Error, Result, invalid, usage};

/// A standard observer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum, Serialize, Deserialize)]
pub enum ObserverName {
    /// CIE 1931, 2 degrees
    #[serde(rename = "1931")]
    #[value(name = "1931")]
    Cie1931,
    /// CIE 1964, 10 degrees
    #[serde(rename = "1964")]
    #[value(name = "1964")]
    Cie1964,
    /// CIE 1931 as Radiance 6.0 integrates it: bins cut at whole nanometres and 1.5 nm toward red, to agree with rcomb
    #[serde(rename = "radiance")]
    #[value(name = "radiance")]
    Radiance,
}

/// Options of `spec2xyz`.
#[derive(Args, Clone, Debug, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields, rename_all = "kebab-case")]
pub struct Spec2xyz {
    /// Standard observer
    #[arg(long, value_enum, value_name = "YEAR", default_value = "1931")]
    pub observer: ObserverName,
    /// Make Y 1 for a perfect diffuser under this illuminant, taken as tabulated: a name such as D65, or a CSV file
    #[arg(long, value_name = "ILLUMINANT", value_hint = ValueHint::FilePath)]
    pub relative_to: Option<String>,
    /// Integrate against this response instead, and the next: tables of spectra/ such as alphaopic_melanopic, or CSV files
    #[arg(long, value_name = "RESPONSE", value_hint = ValueHint::FilePath, conflicts_with_all = ["observer", "relative_to"])]
    pub response: Vec<String>,
    /// With --response: times this, such as 683 lm/W
    #[arg(long, value_name = "K", default_value_t = 1.0, requires = "response")]
    pub factor: f64,
}
clap_defaults!(Spec2xyz);

/// A table by name or file.
fn table(name: &str) -> Result<Spectrum> {
    if !text::is_file(name) {
        return builtin::spectrum(name);
    }
    let content = crate::files::read_to_string(name).map_err(|e| Error::io(name, e))?;
    text::parse(name, &content).map_err(|e| e.within(name))
}

impl Spec2xyz {
    fn observer(&self) -> Result<Observer> {
        match self.observer {
            ObserverName::Cie1931 | ObserverName::Radiance => Observer::cie1931(),
            ObserverName::Cie1964 => Observer::cie1964(),
        }
    }

    /// Any weighted sums.
    fn responses(&self, input: Box<dyn Picture>) -> Result<Box<dyn Picture>> {
        if !(self.factor.is_finite() && self.factor != 0.0) {
            return usage!("--factor {} must be a number other than 0", self.factor);
        }
        let sampling = sampling(input.header())?;
        let mut rows = Vec::new();
        for name in &self.response {
            let weights = sampling.response_weights(&table(name)?);
            rows.push(weights.into_iter().map(|w| w * self.factor).collect::<Vec<f64>>());
        }
        let mut header = input.header().clone();
        header.become_tristimulus(Components::Response, Units::Weighted);
        integrated(input, header, &rows)
    }
}

fn sampling(header: &Header) -> Result<Sampling> {
    if !matches!(header.components, Components::Spectrum | Components::Stokes) {
        return invalid!("expected a spectrum, the picture is {}", header.components);
    }
    header.sampling.clone().ok_or_else(|| Error::Invalid("the picture lists no wavelengths".into()))
}

/// How far toward red Radiance 6.0's table of cumulative colour matching functions lies, nm: found by giving `rcomb -c XYZ`
/// one band at a time (tests/ref/radiance_observer.csv).
const RADIANCE_SHIFT_NM: f64 = 1.5;

/// Radiance's own weights for equal bins.
fn radiance_weights(sampling: &Sampling, observer: &Observer) -> Result<[Vec<f64>; 3]> {
    let Sampling::Bins { count, .. } = sampling else {
        return invalid!("--observer radiance knows equal bins only, the picture lists wavelengths");
    };
    let bin = |cmf: &Spectrum, i| {
        let (a, b) = sampling.edges(i);
        crate::units::K_M * cmf.integral(a.floor() + RADIANCE_SHIFT_NM, b.floor() + RADIANCE_SHIFT_NM)
    };
    Ok(observer.cmf.each_ref().map(|cmf| (0..*count).map(|i| bin(cmf, i)).collect()))
}

impl Filter for Spec2xyz {
    const NAME: &'static str = "spec2xyz";
    const ABOUT: &'static str = "Integrate spectral radiance to XYZ in cd/m2 (Eq. 4), or against any response";
    const EXAMPLE: &'static str = "spectrace --output spectrum scenes/cornell.toml | spec2xyz > cornell.lux\nspec2xyz --response alphaopic_melanopic < spectrum.lux | picinfo";

    fn start(self, input: Option<Box<dyn Picture>>, _: &Run) -> Result<Product> {
        let input = input.ok_or_else(|| Error::Usage("expected a picture".into()))?;
        if !self.response.is_empty() {
            return self.responses(input).map(Product::Picture);
        }
        if self.observer == ObserverName::Cie1931 && self.relative_to.is_none() {
            return tristimulus(input).map(Product::Picture);
        }
        let observer = self.observer()?;
        let mut rows = match self.observer {
            // A matrix in the header stands for the 1931 observer.
            ObserverName::Cie1931 => weights(input.header(), &observer)?,
            ObserverName::Cie1964 => sampling(input.header())?.xyz_weights(&observer),
            ObserverName::Radiance => radiance_weights(&sampling(input.header())?, &observer)?,
        };
        sampling(input.header())?;
        let mut header = input.header().clone();
        header.become_tristimulus(Components::Xyz, Units::CdM2);
        if let Some(name) = &self.relative_to {
            let xyz = observer.integrate(&table(name)?);
            let white = Xy::of(xyz).ok_or_else(|| Error::Invalid(format!("--relative-to {name}: no visible light")))?;
            let scale = 1.0 / (crate::units::K_M * xyz[1]);
            rows.iter_mut().flatten().for_each(|w| *w *= scale);
            header.units = Units::Relative;
            header.white = Some(white);
        }
        integrated(input, header, &rows).map(Product::Picture)
    }
}
