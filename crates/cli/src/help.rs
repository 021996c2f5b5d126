//! Examples, notes and exit codes at the end of each help text.

macro_rules! exit_codes {
    ($findings:literal) => {
        concat!(
            "\n\nEXIT CODES:\n  0  done\n  1  ",
            $findings,
            "\n  2  refused: invalid input or option\n  3  internal error: please report it"
        )
    };
}

/// Of `gimage` itself.
pub const TOP: &str = concat!(
    "EXAMPLES:\n",
    "  gimage build shirt.glb -o shirt.gim\n",
    "  gimage list shirt.glb\n",
    "  gimage inspect shirt.gim\n",
    "  gimage validate shirt.gim\n",
    "  gimage reconstruct shirt.gim -o back.obj\n",
    "  gimage simulate s1 --frames 600\n",
    "  gimage render shirt.gim -o shirt.png\n",
    "  gimage export shirt.gim -o shirt.glb\n",
    "  gimage dress mage.glb -o mage.gim\n",
    "  gimage fit-colliders character.glb -o body.json\n",
    "  gimage check-crossings shirt.gim\n",
    "  gimage doctor\n\n",
    "Results go to stdout, messages to stderr. NO_COLOR turns colours off.",
    exit_codes!("done, with findings (repairs, accessories, warnings; broken rules)")
);

/// Of `gimage build`.
pub const BUILD: &str = concat!(
    "EXAMPLES:\n",
    "  gimage build shirt.glb -o shirt.gim\n",
    "  gimage build skirt.obj -o skirt.gim --unit 0.01 --texels 65536 --pin above:0.98\n",
    "  gimage build flag.obj -o flag.gim --size 64x48 --pin loop:0 --force\n",
    "  gimage build shirt.glb -o shirt.gim --pin above:1.4 --limit above:1.2=0.03\n",
    "  gimage build coat.glb -o coat.gim --up Z --center --pin above:0.9\n",
    "  gimage build mage.glb -o mage.gim --pins auto\n",
    "  gimage build coat.glb -o coat.gim --pin 'material:Collar* or loop:top'\n",
    "  gimage build mage.glb -o mage.gim --cloth 'Mage_Cape,*Skirt*' --body Mage_Head\n",
    "  gimage build *.glb -o bundles --json --threads 4\n\n",
    "The same input and options give the same bytes. With several inputs, a failed build does not stop the others, and the ",
    "exit code is the highest one. A failed build writes nothing, and neither does one whose report cannot be written to ",
    "stdout; with several inputs, bundles written before that stay. --force replaces a bundle in one step; it refuses a ",
    "directory with files that its manifest does not list. Hints (a file that looks like centimetres, or like Z up) do not ",
    "change the exit code.",
    exit_codes!("done, with findings: repairs, accessories, or low quality")
);

/// Of `gimage list`.
pub const LIST: &str = concat!(
    "EXAMPLES:\n",
    "  gimage list mage.glb\n",
    "  gimage list mage.glb --cloth '*Cape*'\n",
    "  gimage list shirt.obj --unit 0.01 --json | jq '.components[].kind'\n\n",
    "Parts are the primitives of glTF, and the objects, groups and materials of OBJ; `build` is what gimage build does with ",
    "them under the same flags. Components are connected triangles after repair. A thin shell has two sheets that face each ",
    "other; its thickness is an estimate. A crumb is too small to be cloth, such as a button. Crumbs, and rows beyond the first ",
    "24 of a table, are shown with -v. Lengths are in metres after --unit and --up.",
    "\n\nEXIT CODES:\n  0  done\n  2  refused: invalid input or option\n  3  internal error: please report it"
);

/// Of `gimage inspect`.
pub const INSPECT: &str = concat!(
    "EXAMPLES:\n",
    "  gimage inspect shirt.gim\n",
    "  gimage inspect shirt.gim --json | jq .quality.psnr\n",
    "  gimage inspect shirt.gim -v\n",
    "  gimage inspect shirt.gim --picture crossings.png",
    "\n\nCrossings are pairs of triangles of the cloth at rest that cross, counted by exact predicates, as\n`gimage check-crossings` counts them.",
    exit_codes!("done, but the manifest disagrees with the images")
);

/// Of `gimage validate`.
pub const VALIDATE: &str = concat!(
    "EXAMPLES:\n",
    "  gimage validate shirt.gim\n",
    "  gimage validate shirt.gim --json | jq '.faults[].message'",
    "\n\nEXIT CODES:\n  0  sound\n  1  findings: the bundle can be read, but breaks a rule\n",
    "  2  unreadable: a file is missing, damaged or of the wrong size; invalid option\n",
    "  3  internal error: please report it"
);

/// Of `gimage reconstruct`.
pub const RECONSTRUCT: &str = concat!(
    "EXAMPLES:\n",
    "  gimage reconstruct shirt.gim -o back.obj\n",
    "  gimage reconstruct shirt.gim -o back.glb --force\n\n",
    "The mesh has texture coordinates if the bundle has a uv map.",
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
    "  gimage simulate s2 --material denim\n",
    "  gimage simulate s2 --solver xpbd --substeps 32 --material cotton,bend=1e-4\n",
    "  gimage simulate s2 --solver xpbd --thickness 0.002\n",
    "  gimage simulate s2 --solver xpbd --material density=0.4,thickness=0.001,friction=1.5\n",
    "  gimage simulate s3 --backend gpu --json | jq .ms_frame_median\n\n",
    "Built-in scenes: s1 (hangs by two corners), s1k (s1 with soft springs), s2 (falls on a sphere), s2f (s2, fast), s3 ",
    "(swings).\n",
    "SCENE.md describes scene files: garments, colliders, pins, wind, motion, cuts. A bundle hangs by its pins, or falls. A ",
    "frame is 1/60 s. Without flags, steps and rounds of polish follow from the scene; the second line of the result says which ",
    "and why. The table is of the end of the run: extension of the structural springs, its largest 99th percentile so far, RMS ",
    "speed, depth in colliders. -v lists the passes. --error measures the largest stretch of each frame, learns from ",
    "changes what steps and rounds of polish do against it, and uses the cheapest numbers that suffice; --polish fixes the ",
    "rounds, and a GPU keeps those of the start. --budget models a frame as a fixed part plus a part per step. On a GPU with ",
    "timestamps, --json times the passes of every 16th frame (gpu_passes); that frame does not count among ms_frame. --dump writes ",
    "frame_NNNNN.<piece>.position.exr, where frame 0 is the start; it refuses a directory with frames of an older run unless ",
    "--force is given, which removes them. Settings beyond the limits of the solver are adjusted, with a warning.",
    exit_codes!("done, but cloth stretched, tunnelled, was thrown, left its body, fell, or overflowed")
);

/// Of `gimage render`.
pub const RENDER: &str = concat!(
    "EXAMPLES:\n",
    "  gimage render shirt.gim -o shirt.png --time 0\n",
    "  gimage render assets/scenes/flag.json -o flag.gif --size 320x240 --fps 20\n",
    "  gimage render mage.gim --animation Walking -o mage.gif\n",
    "  gimage render mage.gim --surface grid --ground on -o grid.png\n",
    "  gimage render assets/scenes/tshirt.json --surface render -o shirt.png\n",
    "  gimage render s2 --n 64 -o s2.png --time 0.8 --camera 1,0.8,1.6,0,0,0 --fov 40\n\n",
    "Without a hardware GPU, cloth and picture are computed on the CPU; --backend gpu accepts any adapter, including a ",
    "software one. 4 samples per pixel. Without a camera, every picture shows all that is drawn. A still picture of a ",
    "bundle without pins, which would fall out of sight, shows its rest pose (default --time 0). The mesh of the source has its base ",
    "colour textures (PNG, JPEG) and alpha; a ground with its shadow, and all else then, is drawn on the CPU.",
    exit_codes!("done, but cloth stretched, tunnelled, was thrown, left its body, fell, or overflowed")
);

/// Of `gimage export`.
pub const EXPORT: &str = concat!(
    "EXAMPLES:\n",
    "  gimage export shirt.gim -o shirt.glb --frames 120\n",
    "  gimage export mage.gim --animation Walking -o mage.usda --fps 24\n",
    "  gimage export shirt.gim -o grid.glb --surface grid\n",
    "  gimage export shirt.gim -o small.glb --compress meshopt\n",
    "  gimage export assets/scenes/flag.json -o frames/flag.obj --every 4 --from 60 --json | jq .bytes\n\n",
    "By default a bundle is written as the mesh of its source (render.glb), moved with the cloth, in a .glb with its materials and ",
    "textures; --surface render does the same for the cloths of a scene file. --surface grid writes the drawn triangles of the particles: a mesh per piece, each point of a seam one vertex, with normals and texture ",
    "coordinates; triangles that a cut has taken away are left out from then on. Metres, Y up. .glb: the first frame with a morph ",
    "target per further frame, weights animated linearly; at most 4 GiB, and 65,536 frames times pieces. .usda: time samples of ",
    "points, normals and extent, with the time codes 1, 2, 3, ... .obj: a file per frame, numbered likewise. With --fps, a frame ",
    "between two steps has interpolated positions, and the normals of the later step. Files take their places at the end, ",
    "together: a run that fails writes nothing.",
    exit_codes!("done, but cloth stretched, tunnelled, was thrown, left its body, fell, or overflowed")
);

/// Of `gimage dress`.
pub const DRESS: &str = concat!(
    "EXAMPLES:\n",
    "  gimage dress mage.glb -o mage.gim\n",
    "  gimage render mage.gim --animation Walking -o mage.gif\n",
    "  gimage dress character.glb -o outfit.gim --cloth Top,Bottom --body Body --pin top:0.1\n",
    "  gimage dress figure.glb -o figure.gim --collider capsules\n\n",
    "As `gimage build`, with the colliders of `gimage fit-colliders` in the manifest; `simulate` and `render` then use them, and ",
    "move them with the joints of --animation. Without --pin and an attribute ",
    "_PIN, garments are pinned where they rest on the body (--pins auto); pins follow the joints.",
    exit_codes!("done, with findings (repairs, accessories, warnings)")
);

/// Of `gimage fit-colliders`.
pub const FIT_COLLIDERS: &str = concat!(
    "EXAMPLES:\n",
    "  gimage fit-colliders character.glb\n",
    "  gimage fit-colliders character.glb -o body.json --collider-shapes capsule --max-colliders 24\n",
    "  gimage fit-colliders character.glb --body Body,Head --collider-error 0.01 --json | jq .error\n",
    "  gimage fit-colliders avatar.vrm --collider-source file\n\n",
    "Parts that look like a body are fitted, see `gimage list`; --body chooses them by name. Colliders follow one joint each and ",
    "are where the character stands as its file has it. Columns: the distance between the part of the body that a ",
    "collider stands for and the surface of all colliders. The file of --output is a scene without cloth: `gimage render` draws ",
    "it, and its colliders can be copied to other scenes.",
    exit_codes!("done, but 5 % of the body are farther away than --collider-error")
);

/// Of `gimage check-crossings`.
pub const CHECK_CROSSINGS: &str = concat!(
    "EXAMPLES:\n",
    "  gimage check-crossings shirt.gim\n",
    "  gimage check-crossings frames\n",
    "  gimage check-crossings frames --scene shirt.gim -v\n",
    "  gimage check-crossings frames --scene s2 --n 64 --json | jq '.inputs[].frames[].within'\n\n",
    "Two triangles cross if their interiors share a point; every decision is exact. Columns: pairs that cross within a cloth and ",
    "between cloths, pairs that touch without crossing, pairs of the same three points (where a seam goes round a corner of ",
    "the image; they do not cross), and the largest depth, the shortest move of one triangle after which the pair no longer crosses. -v lists the deepest pairs by piece and texel. Duplicates of a seam point are one point. Without ",
    "--scene, each image of a frame is a cloth of its own. A dump does not record cuts: triangles that a cut has taken away count ",
    "too.",
    "\n\nEXIT CODES:\n  0  no triangles cross\n  1  triangles cross, or positions are not finite\n",
    "  2  refused: invalid input or option\n  3  internal error: please report it"
);

/// Of `gimage doctor`.
pub const DOCTOR: &str = concat!(
    "EXAMPLES:\n",
    "  gimage doctor\n",
    "  gimage doctor --json | jq '.adapters[].self_check.passed'\n\n",
    "The self-check steps two small seamed cloths on each adapter and compares the results with those of the CPU. `simulate` ",
    "and `render` run it at their start; they use an adapter that fails only with --backend gpu.",
    exit_codes!("done, but an adapter failed its self-check")
);
