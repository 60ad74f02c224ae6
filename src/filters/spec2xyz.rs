//! spec2xyz: spectral radiance to tristimulus values, Eq. (4).

use clap::Args;
use serde::{Deserialize, Serialize};

use crate::clap_defaults;
use crate::filter::{Filter, Product, Run};
use crate::stream::{Picture, tristimulus};
use crate::{Error, Result};

/// Options of `spec2xyz`: none yet beyond the common ones.
#[derive(Args, Clone, Debug, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields, rename_all = "kebab-case")]
pub struct Spec2xyz {}
clap_defaults!(Spec2xyz);

impl Filter for Spec2xyz {
    const NAME: &'static str = "spec2xyz";
    const ABOUT: &'static str = "Integrate spectral radiance to XYZ in cd/m2 (CIE 1931, 683 lm/W)";
    const EXAMPLE: &'static str = "spectrace --output spectrum scenes/cornell.toml | spec2xyz > cornell.xyz";

    fn start(self, input: Option<Box<dyn Picture>>, _: &Run) -> Result<Product> {
        let input = input.ok_or_else(|| Error::Usage("expected a picture".into()))?;
        tristimulus(input).map(Product::Picture)
    }
}
