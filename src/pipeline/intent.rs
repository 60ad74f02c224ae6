//! `--intent`: the whole chain for a rendering intent, without a file.

use std::path::{Path, PathBuf};

use super::tree::{Node, Work};
use crate::display::Display;
use crate::filter::{Filter, Stage};
use crate::filters::{self, Intent};
use crate::options::ReadOptions;
use crate::{Error, Result, usage};

/// The chain that an intent means. Perceptual and saturation: adaptation, histogram adjustment, the gamut rule, PNG; colorimetric: the
/// stimulus itself, PNG. A scene is rendered first.
pub fn chain(intent: Intent, input: &Path, output: Option<PathBuf>, display: &Display) -> Result<Node> {
    let png = |p: &PathBuf| p.as_os_str() == "-" || p.extension().is_some_and(|e| e.eq_ignore_ascii_case("png"));
    if let Some(other) = output.as_ref().filter(|p| !png(p)) {
        return usage!("{}: --intent writes PNG; name a .png file", other.display());
    }
    let display = || Some(display.clone());
    let mut chain = Chain { stages: Vec::new(), input: Some(input.to_path_buf()) };
    if input.extension().is_some_and(|e| e == "toml") {
        chain.input = None;
        chain.add(filters::Spectrace { scene: Some(input.to_path_buf()), ..Default::default() });
    }
    if intent != Intent::Colorimetric {
        chain.add(filters::Vonkries { display: display(), ..Default::default() });
        chain.add(filters::Pcond { display: display(), ..Default::default() });
    }
    chain.add(filters::Xyz2rgb { display: display(), intent: Some(intent), ..Default::default() });
    chain.add(filters::RaPng { display: display(), ..Default::default() });
    if let Some(last) = chain.stages.last_mut() {
        last.output = output;
    }
    chain.tree().ok_or_else(|| Error::Usage("an intent needs a picture".into()))
}

/// Stages one after the other; the first that reads gets the input.
struct Chain {
    stages: Vec<Stage>,
    input: Option<PathBuf>,
}

impl Chain {
    fn add<F: Filter>(&mut self, own: F) {
        let read =
            if F::READS { ReadOptions { input: self.input.take(), ..Default::default() } } else { Default::default() };
        self.stages.push(Stage::new(own, read, None, Default::default(), Default::default()));
    }

    fn tree(self) -> Option<Node> {
        let numbered = (1..).zip(self.stages).collect::<Vec<_>>();
        let before = |after: Option<Node>, (nth, stage): (usize, Stage)| {
            Some(Node {
                nth,
                work: Work::Filter(Box::new(stage)),
                branches: after.into_iter().collect(),
                recorder: false,
            })
        };
        numbered.into_iter().rev().fold(None, before)
    }
}
