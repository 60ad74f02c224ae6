//! `{ type = "henyey_greenstein", g = 0.8 }`: mostly forward for g above 0, back below; g is the mean cosine, -0.9999 to 0.9999.
//!
//! p = (1 - g^2) / (4 pi (1 + g^2 - 2 g cos)^(3/2)) [Henyey 1941].

use std::f32::consts::PI;
use std::sync::Arc;

use crate::Result;
use crate::keys::Keys;
use crate::medium::phase::Phase;

/// By its mean cosine.
#[derive(Clone, Copy, Debug)]
pub struct HenyeyGreenstein {
    g: f32,
}

impl HenyeyGreenstein {
    /// `g` above -1 and below 1.
    pub fn new(g: f32) -> HenyeyGreenstein {
        HenyeyGreenstein { g }
    }
}

impl Phase for HenyeyGreenstein {
    /// ```
    /// use luxpipe::medium::phase::{Phase, henyey_greenstein::HenyeyGreenstein};
    /// // Straight on (1 + g) / (4 pi (1 - g)^2), however narrow the peak.
    /// let p = HenyeyGreenstein::new(0.999).value(0.0);
    /// assert!((p / 159_075.0 - 1.0).abs() < 1e-3);
    /// ```
    fn value(&self, versine: f32) -> f32 {
        let g = self.g;
        let base = (1.0 - g) * (1.0 - g) + 2.0 * g * versine;
        (1.0 - g) * (1.0 + g) / (4.0 * PI * base * base.sqrt())
    }

    fn sample(&self, u: f32) -> f32 {
        let g = self.g;
        // s = (1 - g^2) / (1 - g + 2 g u) of the usual inversion, which is 1 - g straight on; nothing is lost by taking the difference.
        let below = 1.0 - g + 2.0 * g * u;
        let s = (1.0 - g) * (1.0 + g) / below;
        ((1.0 - g) * (1.0 - u) / below * (s + 1.0 - g)).min(2.0)
    }

    fn mean_cosine(&self) -> f64 {
        self.g.into()
    }
}

/// Reads one.
pub fn read(keys: &mut Keys) -> Result<Arc<dyn Phase>> {
    let Some(g) = keys.number("g", "must lie in -0.9999 to 0.9999", |g| g.abs() <= 0.9999)? else {
        return Err(keys.wrong("key 'g' is missing"));
    };
    Ok(Arc::new(HenyeyGreenstein::new(g as f32)))
}
