//! Laws that hold whatever the numbers are: on random materials, scenes, pictures and displays. A case that fails is made
//! smaller, and its numbers printed.

#[path = "laws/chance.rs"]
mod chance;
mod common;
#[path = "laws/light.rs"]
mod light;
#[path = "laws/matter.rs"]
mod matter;
#[path = "laws/pictures.rs"]
mod pictures;
