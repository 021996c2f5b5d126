//! The examples and exit codes at the end of each help text.

macro_rules! exit_codes {
    ($findings:literal) => {
        concat!(
            "\n\nEXIT CODES:\n  0  done\n  1  ",
            $findings,
            "\n  2  could not do it: bad input, bad flag\n  3  internal error: please report it"
        )
    };
}

/// Of `gimage` itself.
pub const TOP: &str = concat!(
    "EXAMPLES:\n",
    "  gimage build shirt.glb -o shirt.gim\n",
    "  gimage inspect shirt.gim\n",
    "  gimage validate shirt.gim\n",
    "  gimage reconstruct shirt.gim -o back.obj\n",
    "  gimage simulate s1 --frames 600\n",
    "  gimage render shirt.gim -o shirt.png\n",
    "  gimage doctor\n\n",
    "Results go to stdout, words to stderr. NO_COLOR turns colours off.",
    exit_codes!("done, with findings (repairs, accessories, warnings; broken rules)")
);

/// Of `gimage build`.
pub const BUILD: &str = concat!(
    "EXAMPLES:\n",
    "  gimage build shirt.glb -o shirt.gim\n",
    "  gimage build skirt.obj -o skirt.gim --unit 0.01 --texels 65536 --pin above:0.98\n",
    "  gimage build flag.obj -o flag.gim --size 64x48 --pin loop:0 --force\n",
    "  gimage build coat.glb -o coat.gim --up Z --center --pin above:0.9\n",
    "  gimage build *.glb -o bundles --json --threads 4\n\n",
    "The same input and options give the same bytes. With several inputs one bad file does not stop the others; ",
    "the exit code is the worst one. A build that fails leaves nothing behind, one whose report cannot be written to stdout ",
    "too; of several inputs the bundles written until then stay. --force replaces a bundle, in one step; it refuses a directory ",
    "with files that its manifest does not list. A hint (a file that seems to be in centimetres, or to have Z up) does not ",
    "change the exit code.",
    exit_codes!("done, with findings: something was repaired, set apart, or is worse than it could be")
);

/// Of `gimage inspect`.
pub const INSPECT: &str = concat!(
    "EXAMPLES:\n",
    "  gimage inspect shirt.gim\n",
    "  gimage inspect shirt.gim --json | jq .quality.psnr\n",
    "  gimage inspect shirt.gim -v",
    exit_codes!("done, but the manifest does not agree with the images")
);

/// Of `gimage validate`.
pub const VALIDATE: &str = concat!(
    "EXAMPLES:\n",
    "  gimage validate shirt.gim\n",
    "  gimage validate shirt.gim --json | jq '.faults[].message'",
    "\n\nEXIT CODES:\n  0  sound\n  1  findings: it can be read, but breaks a rule\n",
    "  2  unreadable: a file is missing, damaged or of the wrong size; bad flag\n",
    "  3  internal error: please report it"
);

/// Of `gimage reconstruct`.
pub const RECONSTRUCT: &str = concat!(
    "EXAMPLES:\n",
    "  gimage reconstruct shirt.gim -o back.obj\n",
    "  gimage reconstruct shirt.gim -o back.glb --force\n\n",
    "The mesh has texture coordinates where the bundle has a uv map.",
    exit_codes!("done, but a piece has no triangles")
);

/// Of `gimage simulate`.
pub const SIMULATE: &str = concat!(
    "EXAMPLES:\n",
    "  gimage simulate s1 --n 64 --substeps 16\n",
    "  gimage simulate shirt.gim --frames 300 --dump frames --every 10\n",
    "  gimage simulate assets/scenes/flag.json --backend cpu\n",
    "  gimage simulate s1 --solver xpbd --substeps 4 --tethers 2\n",
    "  gimage simulate s1 --solver xpbd --error 0.01 --budget 2\n",
    "  gimage simulate s2 --solver xpbd --substeps 32 --material warp=300,bend=1e-4\n",
    "  gimage simulate s2 --solver xpbd --thickness 0.002\n",
    "  gimage simulate s2 --solver xpbd --material density=0.4,thickness=0.001,friction=1.5\n",
    "  gimage simulate s3 --backend gpu --json | jq .ms_frame_median\n\n",
    "Built in: s1 (hung by two corners), s1k (with soft springs), s2 (falls on a sphere), s2f (fast), s3 (swings).\n",
    "SCENE.md describes scene files: garments, colliders, pins, wind, motion, cuts. A bundle falls or hangs by its pins. Frames take 1/60 s. ",
    "--error measures the largest stretch of each frame and changes the number of steps by the rule that it falls with their ",
    "square; --budget goes by the median time of a step. --dump writes frame_NNNNN.<piece>.position.exr, frame 0 ",
    "being the start; it refuses a directory with frames of an older run unless --force removes them. Settings beyond the solver's limits are changed, and stderr says so.",
    exit_codes!("done, but cloth overflowed: frames were taken back, or positions are not finite")
);

/// Of `gimage render`.
pub const RENDER: &str = concat!(
    "EXAMPLES:\n",
    "  gimage render shirt.gim -o shirt.png --time 0\n",
    "  gimage render assets/scenes/flag.json -o flag.gif --size 320x240 --fps 20\n",
    "  gimage render s2 --n 64 -o s2.png --time 0.8 --camera 1,0.8,1.6,0,0,0 --fov 40\n\n",
    "Without a real GPU both the cloth and the picture are made on the CPU; --backend gpu takes any adapter, a software ",
    "one too. Four samples per pixel. Without a camera all cloths and colliders are in every picture. A still picture of ",
    "a bundle without pins, which would fall out of sight, shows its rest pose unless --time is given.",
    exit_codes!("done, but cloth overflowed: frames were taken back, or positions are not finite")
);

/// Of `gimage doctor`.
pub const DOCTOR: &str = concat!(
    "EXAMPLES:\n",
    "  gimage doctor\n",
    "  gimage doctor --json | jq '.adapters[].self_check.passed'\n\n",
    "The self-check steps two small seamed cloths on each adapter and compares the result with the CPU's. `simulate` and ",
    "`render` run it too, at their start, and leave an adapter that fails alone unless --backend gpu asks for it.",
    exit_codes!("done, but an adapter failed its self-check")
);
