use super::*;
use crate::row::HEADER;

fn point(scene: &str, n: u32, solver: &str, ms: f64, error: f64) -> Point {
    let (scene, solver, label) = (scene.into(), solver.into(), "8".into());
    Point { scene, n, worn: false, solver, label, ms, error: [error; 3] }
}

#[test]
fn every_point_is_drawn_and_nothing_is_not_a_number() {
    let mut points = vec![
        point("s1", 32, "classic", 0.1, 0.3),
        point("s1", 64, "classic", 0.2, 4.0),
        point("s2", 64, "xpbd", 0.2, 0.0),
    ];
    points.push(Point { worn: true, error: [2.0, 1.0, 3.0], ..point("cape", 64, "xpbd", 2.0, 0.0) });
    let svg = draw(&points);
    // Each solver once in the legend, and each of its points.
    assert_eq!((svg.matches("<circle").count(), svg.matches("width=\"6.6\"").count()), (3, 3));
    assert!(svg.contains("cape, 4096 texels") && !svg.contains("NaN") && !svg.contains("inf"));
    assert_eq!(svg.matches("<g ").count(), svg.matches("</g>").count());
}

#[test]
fn a_plot_without_points_still_draws() {
    assert!(draw(&[]).ends_with("</svg>\n"));
}

#[test]
fn points_come_from_all_three_tables() {
    let built_in = format!(
        "{HEADER}\ns1,32,xpbd,4,cpu,600,0.1,0.2,0,0.015,0.001,,,,,,,,\ns2,32,xpbd,4,cpu,60,0.1,0.2,1,,,,,,,,,,\n"
    );
    assert_eq!(read(&built_in).unwrap(), [Point { label: "4".into(), ..point("s1", 32, "xpbd", 0.1, 1.5) }]);
    let worn = format!(
        "{}\ncape,4096,12,4,0,0,180,3.0,9,0,0.01,0,0,0,\ncape,4096,12,4,0,1,180,2.0,9,0,0.03,0,0,0,\ncape,4096,1000,0,2,0,180,,,0,0.01,0,0,0,0\n",
        crate::worn::HEADER
    );
    let read_worn = read(&worn).unwrap();
    assert_eq!((read_worn.len(), read_worn[0].ms, read_worn[0].n), (1, 2.0, 64));
    assert_eq!((&*read_worn[0].solver, read_worn[0].error), ("defaults", [2.0, 1.0, 3.0]));
    let peers = read(include_str!("../../../peers/cloth.csv")).unwrap();
    assert!(peers.iter().any(|p| p.solver == "NvCloth" && p.label == "16" && p.n == 64 && p.ms == 0.687));
    assert!(peers.iter().any(|p| p.solver == "other solvers" && p.label == "bevy_silk"));
    assert!(read("a,b\n1,2\n").is_err());
}
