//! What is tried: methods with how hard they try, and what paths carry.

/// A method of spectrace with ever more work.
pub struct Method {
    /// As spectrace has it.
    pub name: &'static str,
    /// Options, from the least work on, each a few times the one before.
    pub efforts: &'static [&'static str],
    /// Of scenes with media that scatter alone.
    pub media_only: bool,
}

/// All of them. A run that takes more than its seconds is the method's last.
pub const METHODS: [Method; 6] = [
    Method {
        name: "path",
        efforts: &[
            "--samples 1",
            "--samples 4",
            "--samples 16",
            "--samples 64",
            "--samples 256",
            "--samples 1024",
            "--samples 4096",
        ],
        media_only: false,
    },
    Method {
        name: "local",
        efforts: &["--samples 1", "--samples 4", "--samples 16", "--samples 64", "--samples 256"],
        media_only: false,
    },
    Method {
        name: "radiosity",
        efforts: &[
            "--samples 4 --mesh-error 0.05 --element-rays 128",
            "--samples 16 --mesh-error 0.02 --element-rays 256",
            "--samples 64 --mesh-error 0.01 --element-rays 1024",
            "--samples 256 --mesh-error 0.005 --element-rays 4096",
        ],
        media_only: false,
    },
    Method {
        name: "photon",
        efforts: &[
            "--samples 4 --photons 20000 --passes 4 --count 50",
            "--samples 8 --photons 200000 --count 100",
            "--samples 32 --photons 1000000",
            "--samples 128 --photons 4000000 --passes 32",
        ],
        media_only: false,
    },
    Method {
        name: "march",
        efforts: &[
            "--samples 1 --step 1",
            "--samples 4 --step 0.3",
            "--samples 16 --step 0.1",
            "--samples 64 --step 0.03",
        ],
        media_only: true,
    },
    Method {
        name: "zonal",
        efforts: &["--samples 4 --zones 4", "--samples 16 --zones 8", "--samples 64 --zones 12"],
        media_only: true,
    },
];

/// The method that a plan is rendered by.
pub const PATH: &str = "path";

/// What paths may carry in place of full bands: so many wavelengths or channels of `specplan --model`, or `bandsN` for N equal bands.
pub const PLANS: [&str; 10] = ["white", "product", "relative", "4", "8", "12", "16", "bands18", "bands80", "specplan"];
