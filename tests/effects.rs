//! What Eq. (1) leaves out, on surfaces and lights, through whole paths: against closed forms and tables, and where methods fail.

#[path = "effects/fluorescence.rs"]
mod fluorescence;
#[path = "effects/lamps.rs"]
mod lamps;
#[path = "effects/polarization.rs"]
mod polarization;
#[path = "effects/scenes.rs"]
mod scenes;
#[path = "effects/transmission.rs"]
mod transmission;
#[path = "effects/waves.rs"]
mod waves;
