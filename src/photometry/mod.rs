//! Quantities and files of lighting practice.
