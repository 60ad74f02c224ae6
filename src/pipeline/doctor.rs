//! `luxpipe doctor`: what this machine has that luxpipe can make use of. None of it is needed.

use std::path::PathBuf;

use crate::filters;
use crate::options::installed;

/// Programs that luxpipe goes together with: what they are called, and what for.
const PEERS: &[(&str, &str)] = &[
    ("rpict", "Radiance: its renderer; every filter reads what it writes"),
    ("pfilt", "Radiance: its filters can be stages, exec = [\"pfilt\", ...] with format = \"rgbe\""),
    ("evalglare", "Radiance: glare, beside pglare"),
    ("make", "batches: luxpipe --make"),
    ("parallel", "batches: luxpipe --shell FILE | parallel"),
    ("snakemake", "clusters: luxpipe --snakemake"),
    ("sbatch", "clusters: Slurm, by way of Snakemake"),
    ("tiffinfo", "looking into LogLuv and Pixar log TIFF"),
    ("exrheader", "looking into OpenEXR"),
    ("oiiotool", "OpenImageIO: other file formats"),
    ("man", "the manual pages that make install leaves"),
];

/// A line for each, and for what runs here.
pub fn report() -> String {
    let mut text = format!("luxpipe {}\n", env!("CARGO_PKG_VERSION"));
    let threads = std::thread::available_parallelism().map_or(1, |n| n.get());
    text += &format!("processors      {threads}, {}\n", crate::simd::width());
    let own = std::env::current_exe().ok();
    let folder = own.as_deref().and_then(|p| p.parent());
    let programs: Vec<String> =
        filters::ALL.iter().map(|f| f.name()).chain(["luxpipe", "tradeoff"]).map(installed).collect();
    let missing: Vec<&String> = programs.iter().filter(|p| folder.is_some_and(|f| !f.join(p).is_file())).collect();
    let beside = folder.map_or("?".into(), |f| f.display().to_string());
    text += &format!("programs        {} of {} in {beside}\n", programs.len() - missing.len(), programs.len());
    for name in missing {
        text += &format!("  missing       {name}\n");
    }
    let mut shadowed = Vec::new();
    for name in &programs {
        let first = on_path(name).into_iter().next();
        match (first, folder.map(|f| f.join(name))) {
            (None, _) => shadowed.push(format!("  not on PATH   {name}\n")),
            (Some(first), Some(own)) if first.canonicalize().ok() != own.canonicalize().ok() => {
                shadowed.push(format!("  shadowed      {name} is {} on PATH\n", first.display()));
            }
            _ => {}
        }
    }
    match shadowed.len() {
        0 => text += "PATH            finds these programs\n",
        n if n == programs.len() && shadowed[0].contains("not on PATH") => {
            text += &format!("PATH            does not have {beside}\n");
        }
        _ => text += &format!("PATH\n{}", shadowed.concat()),
    }
    text += "beside luxpipe, none of it needed:\n";
    for (name, what) in PEERS {
        let found = on_path(name).into_iter().find(|p| p.parent() != folder);
        let place = found.map_or("-".to_string(), |p| p.display().to_string());
        text += &format!("  {name:13} {place:30} {what}\n");
    }
    text
}

/// Where the search path has a program, first things first.
fn on_path(name: &str) -> Vec<PathBuf> {
    let path = std::env::var_os("PATH").unwrap_or_default();
    std::env::split_paths(&path).map(|folder| folder.join(name)).filter(|p| p.is_file()).collect()
}
