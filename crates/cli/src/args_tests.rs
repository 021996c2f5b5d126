use gimage::caps::Caps;
use gimage::import::Up;
use gimage::limits::Limit;
use gimage::options::{BuildOptions, Effort, ImageSize, RestLength, Sample, Seams};
use gimage::pins::Pin;
use gimage::render::RenderMesh;
use gimage::select::Pattern;
use gimage::shell::Layer;
use gimage::strands::Strands;

use super::*;
use clap::CommandFactory;

fn build(flags: &[&str]) -> Result<BuildOptions, clap::Error> {
    let cli = Cli::try_parse_from(["gimage", "build", "in.obj", "-o", "out.gim"].iter().chain(flags))?;
    let Command::Build(args) = cli.command else { panic!("not a build") };
    Ok(args.options())
}

#[test]
fn the_parser_is_consistent() {
    Cli::command().debug_assert();
}

#[test]
fn nothing_said_is_the_default() {
    assert_eq!(build(&[]).unwrap(), BuildOptions::default());
}

#[test]
fn every_flag_reaches_the_options() {
    let flags = "--size 64x32 --sample point --seams uv --piece a --piece b --pin above:-1.5 --pin loop:0 --limit below:1=0.05 --unit 0.01 --up -Z --center \
                 --weld 1e-4 --accessory-area 0.05 --rest arc --density 0.3 --detail 0.25 --effort best \
                 --no-metrics --cloth a*,b --cloth c --body head --rigid staff --strands keep --caps open --shell outer --render-mesh off";
    let o = build(&flags.split_whitespace().collect::<Vec<_>>()).unwrap();
    assert_eq!((o.image.size, o.image.sample, o.image.seams), (ImageSize::Exact(64, 32), Sample::Point, Seams::Uv));
    assert_eq!((o.import.pieces, o.import.unit), (vec!["a".to_owned(), "b".to_owned()], 0.01));
    let names = |list: &[Pattern]| list.iter().map(ToString::to_string).collect::<Vec<_>>().join(" ");
    assert_eq!([&o.select.cloth, &o.select.body, &o.select.rigid].map(|l| names(l)), ["a* b c", "head", "staff"]);
    assert_eq!((o.import.up, o.import.center), (Up::MinusZ, true));
    assert_eq!(o.assemble.pins, [Pin::Above(-1.5), Pin::Loop(0)]);
    assert_eq!(o.assemble.limits, [Limit { particles: Pin::Below(1.0), distance: 0.05 }]);
    assert_eq!((o.repair.weld, o.component.accessory_area, o.mass.density), (Some(1e-4), 0.05, 0.3));
    assert_eq!((o.assemble.rest, o.gate.metrics), (RestLength::Arc, false));
    assert_eq!((o.image.detail, o.image.effort, o.shell.shell), (0.25, Effort::Best, Layer::Outer));
    assert_eq!(o.strands.strands, Strands::Keep);
    assert_eq!((o.caps.caps, o.render.render_mesh), (Caps::Open, RenderMesh::Off));
    assert_eq!(build(&["--texels", "99"]).unwrap().image.size, ImageSize::Texels(99));
    assert_eq!(build(&["--spacing", "0.01"]).unwrap().image.size, ImageSize::Spacing(0.01));
}

#[test]
fn a_negative_number_is_told_what_its_option_takes() {
    for (args, says) in [
        ("render s1 -o a.png --time -3", "invalid value '-3' for '--time <SECONDS>': give at least 0 seconds"),
        ("build a.obj -o a.gim --density -1", "invalid value '-1' for '--density <KG_M2>': give a number above 0"),
        ("build a.obj -o a.gim --texels -1", "invalid value '-1' for '--texels <N>'"),
        ("simulate s1 --frames -1", "invalid value '-1' for '--frames <F>'"),
    ] {
        let error = Cli::try_parse_from(["gimage"].into_iter().chain(args.split_whitespace())).unwrap_err().to_string();
        assert!(error.contains(says), "{error}");
    }
}

#[test]
fn nonsense_is_refused() {
    for flags in [
        "--size 64",
        "--size 64x",
        "--texels -1",
        "--texels 9 --size 9x9",
        "--spacing 0",
        "--unit nan",
        "--weld -1",
        "--pin up:3",
        "--limit above:1",
        "--limit above:1=-1",
        "--up W",
        "--sample best",
        "--threads 5000",
        "--bogus",
        "-q -v",
    ] {
        let error = build(&flags.split_whitespace().collect::<Vec<_>>()).unwrap_err();
        assert_eq!(error.exit_code(), 2, "{flags}");
    }
}
