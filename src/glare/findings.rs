//! What a field of view holds, for a person to read and for a script.

use std::f64::consts::PI;
use std::fmt::Write as _;

use crate::glare::indices::{self, Light, Scene, Veil};
use crate::glare::sources::{self, Search, Source};
use crate::glare::{Field, Sums};
use crate::json::Json;
use crate::{Result, usage};

/// From which luminance a pixel glares.
#[derive(Clone, Copy, Debug)]
pub enum Threshold {
    /// cd/m2
    Fixed(f64),
    /// Times the mean of the field, or of a task: pixels from the left, from the bottom, and the angle across, rad.
    Times(f64, Option<[f64; 3]>),
}

/// What counts as the background's luminance.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Background {
    /// (Ev - Edir) / pi [CIE 117]
    Indirect,
    /// Mean of the pixels that do not glare.
    Mean,
    /// Ev / pi
    Total,
}

/// How to look.
#[derive(Clone, Copy, Debug)]
pub struct Settings {
    /// Of a glaring pixel.
    pub threshold: Threshold,
    /// See [`Search`].
    pub radius_rad: f64,
    /// See [`Search`].
    pub peak_cd_m2: f64,
    /// Ev as measured, lux.
    pub illuminance_lux: Option<f64>,
    /// Of the indices.
    pub background: Background,
    /// Formula of the veiling luminance.
    pub veil: Veil,
    /// Age of the observer.
    pub age_years: f64,
    /// Pigment of the eye, for [`Veil::Cie`].
    pub pigment: f64,
}

/// What was found.
pub struct Findings {
    all: Sums,
    scene: Scene,
    threshold_cd_m2: f64,
    /// Those that give most light first.
    sources: Vec<Source>,
    lights: Vec<Light>,
}

impl Settings {
    fn threshold_cd_m2(&self, field: &Field, all: &Sums) -> Result<f64> {
        let (factor, task) = match self.threshold {
            Threshold::Fixed(cd_m2) => return Ok(cd_m2),
            Threshold::Times(factor, task) => (factor, task),
        };
        let Some([x, y, angle]) = task else { return Ok(factor * all.mean()) };
        let (u, v) = ((x + 0.5) / field.width as f64, (y + 0.5) / field.height as f64);
        let inside = (0.0..1.0).contains(&u) && (0.0..1.0).contains(&v);
        let centre = field.view.direction(u, v).filter(|d| inside && d[2] >= 0.0);
        let Some(centre) = centre else { return usage!("--task {x},{y} lies outside the field of view") };
        let near = |d: &[f64; 3]| d.iter().zip(centre).map(|(a, b)| a * b).sum::<f64>() >= (0.5 * angle).cos();
        let mut sums = Sums::default();
        field.rays().filter(|(_, ray)| near(&ray.direction)).for_each(|(_, ray)| sums.add(&ray));
        Ok(factor * if sums.solid_angle_sr > 0.0 { sums.mean() } else { all.mean() })
    }
}

impl Findings {
    /// Finds the sources of a field and sums up.
    pub fn of(field: &Field, settings: &Settings) -> Result<Findings> {
        let all = field.sums();
        let threshold_cd_m2 = settings.threshold_cd_m2(field, &all)?;
        let search = Search { threshold_cd_m2, radius_rad: settings.radius_rad, peak_cd_m2: settings.peak_cd_m2 };
        let veiling = |ray: &_| indices::veiling_cd_m2(ray, settings.veil, settings.age_years, settings.pigment);
        let mut sources = sources::find(field, &search, veiling);
        sources.sort_by(|a, b| b.sums.illuminance_lux.total_cmp(&a.sums.illuminance_lux));
        let glaring = sources.iter().fold(Sums::default(), |sum, s| sum.plus(&s.sums));
        let illuminance_lux = settings.illuminance_lux.unwrap_or(all.illuminance_lux);
        let direct_lux = glaring.illuminance_lux;
        let background_cd_m2 = match settings.background {
            Background::Indirect => (illuminance_lux - direct_lux).max(0.0) / PI,
            Background::Mean => all.minus(&glaring).mean(),
            Background::Total => illuminance_lux / PI,
        };
        let lights = sources.iter().map(Light::from).collect();
        let scene = Scene { illuminance_lux, direct_lux, mean_cd_m2: all.mean(), background_cd_m2 };
        Ok(Findings { all, scene, threshold_cd_m2, sources, lights })
    }

    /// The share of the hemisphere before the eye that the picture shows.
    pub fn hemisphere(&self) -> f64 {
        self.all.solid_angle_sr / (2.0 * PI)
    }

    /// Veiling luminance of all sources, cd/m2.
    fn veiling_cd_m2(&self) -> f64 {
        self.sources.iter().fold(0.0, |sum, s| sum + s.veiling_cd_m2)
    }

    /// Name in words, key, value of each index.
    fn indices(&self) -> [(&'static str, &'static str, f64); 9] {
        let (scene, lights) = (&self.scene, &self.lights[..]);
        let (dgp, dgr) = (indices::dgp(scene, lights), indices::dgr(scene, lights));
        [
            ("DGP", "dgp", dgp),
            ("DGP low light", "dgp_low_light", dgp * indices::low_light(scene.illuminance_lux)),
            ("DGI", "dgi", indices::dgi(scene, lights)),
            ("UGR", "ugr", indices::ugr(scene, lights)),
            ("UGP", "ugp", indices::ugp(scene, lights)),
            ("UGP2", "ugp2", indices::ugp2(scene, lights)),
            ("CGI", "cgi", indices::cgi(scene, lights)),
            ("DGR", "dgr", dgr),
            ("VCP", "vcp", indices::vcp(dgr)),
        ]
    }

    /// Lines to read.
    pub fn text(&self) -> String {
        let (mut text, s) = (String::new(), &self.scene);
        let share = 100.0 * self.hemisphere();
        let _ = writeln!(text, "field          {:.3} sr, {share:.1} % of the hemisphere", self.all.solid_angle_sr);
        let _ =
            writeln!(text, "illuminance    {:.1} lux at the eye, {:.1} by sources", s.illuminance_lux, s.direct_lux);
        let _ = writeln!(text, "average        {:.4} cd/m2", s.mean_cd_m2);
        let _ = writeln!(text, "background     {:.4} cd/m2", s.background_cd_m2);
        let _ = writeln!(text, "sources        {} above {:.1} cd/m2", self.sources.len(), self.threshold_cd_m2);
        if !self.sources.is_empty() {
            let _ = writeln!(
                text,
                "  {:>3} {:>8} {:>10} {:>10} {:>10} {:>7} {:>7} {:>6} {:>9} {:>8}",
                "", "pixels", "sr", "cd/m2", "max", "right", "up", "P", "lux", "veil"
            );
        }
        for (i, (source, light)) in self.sources.iter().zip(&self.lights).enumerate() {
            let [x, y, z] = source.direction();
            let _ = writeln!(
                text,
                "  {:>3} {:>8} {:>10.3e} {:>10.1} {:>10.1} {:>7.2} {:>7.2} {:>6.3} {:>9.2} {:>8.3}",
                i + 1,
                source.pixels,
                light.solid_angle_sr,
                light.luminance_cd_m2,
                source.max_cd_m2,
                x.atan2(z).to_degrees(),
                y.clamp(-1.0, 1.0).asin().to_degrees(),
                light.position_index,
                source.sums.illuminance_lux,
                source.veiling_cd_m2
            );
        }
        for (name, _, value) in self.indices() {
            let _ = writeln!(text, "{name:14} {value:.4}");
        }
        let _ = writeln!(text, "veil           {:.4} cd/m2", self.veiling_cd_m2());
        let ti = indices::threshold_increment(self.veiling_cd_m2(), s.background_cd_m2);
        let ti = ti.map_or("none: the background is black".into(), |x| format!("{x:.2} %"));
        let _ = writeln!(text, "TI             {ti}");
        text
    }

    /// The same as one object.
    pub fn json(&self) -> Json {
        let s = &self.scene;
        let each = self.sources.iter().zip(&self.lights).map(|(source, light)| {
            Json::object([
                ("pixels", source.pixels.into()),
                ("solid_angle_sr", light.solid_angle_sr.into()),
                ("luminance_cd_m2", light.luminance_cd_m2.into()),
                ("max_cd_m2", source.max_cd_m2.into()),
                ("direction", Json::list(source.direction())),
                ("angle_deg", source.angle_deg().into()),
                ("position_index", light.position_index.into()),
                ("illuminance_lux", source.sums.illuminance_lux.into()),
                ("veiling_cd_m2", source.veiling_cd_m2.into()),
            ])
        });
        let veil = self.veiling_cd_m2();
        let head = [
            ("solid_angle_sr", self.all.solid_angle_sr.into()),
            ("illuminance_lux", s.illuminance_lux.into()),
            ("direct_lux", s.direct_lux.into()),
            ("average_cd_m2", s.mean_cd_m2.into()),
            ("background_cd_m2", s.background_cd_m2.into()),
            ("threshold_cd_m2", self.threshold_cd_m2.into()),
        ];
        let tail = [
            ("veiling_cd_m2", veil.into()),
            ("threshold_increment", indices::threshold_increment(veil, s.background_cd_m2).into()),
            ("sources", Json::list(each)),
        ];
        let indices = self.indices().map(|(_, key, value)| (key, value.into()));
        Json::object(head.into_iter().chain(indices).chain(tail))
    }
}
