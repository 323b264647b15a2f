//! Places read from a camera image, checked by hand and against the same programs with all places in lengths.

use crate::scene::{Random, cases};
use crate::support::{Built, build};
use tweeze::claims::Order;
use tweeze::claims::dimibot::{Asked, DimibotAction, DimibotObstacleBody};
use tweeze::geometry::shape::{Pose, Shape};

const BOT: &str = "use std.dimibot\ndevice bot : dimibot.femto_st { left: 5, right: 5 }\n";

/// The order of the only task.
fn order(text: &str) -> tweeze::claims::dimibot::DimibotOrder {
    let built = build(text);
    assert_eq!(built.codes, [""; 0], "{:?}\n{text}", built.titles);
    let Order::Dimibot(order) = &built.schedules[0].claims().jobs[0].order else { panic!("a DiMiBot") };
    order.clone()
}

/// The compiler's coordinates of the goal of `move to`.
fn goal_um(image: &str, goal: &str) -> [f64; 2] {
    let text =
        format!("{BOT}scene bench {{\n  frame top : {image}\n}}\ntask go on bot in bench {{ move to {goal} }}\n");
    let order = order(&text);
    let DimibotAction::Move(stops) = &order.steps[0].action else { panic!("a move") };
    let Asked::Place(place_um) = stops[0].asked else { panic!("a place") };
    place_um
}

fn assert_near(one: &[f64], other: &[f64]) {
    assert!(one.iter().zip(other).all(|(a, b)| (a - b).abs() < 1e-9), "{one:?} {other:?}");
}

#[test]
fn pixels_are_places_as_computed_by_hand() {
    // Half a micrometre per pixel; y points down the image.
    let upright = "image { scale: 0.5 um/px, origin: (10 px, 20 px) } at (3 um, 4 um)";
    assert_near(&goal_um(upright, "(10 px, 20 px)"), &[3.0, 4.0]);
    assert_near(&goal_um(upright, "(14 px, 20 px)"), &[5.0, 4.0]);
    assert_near(&goal_um(upright, "(10 px, 14 px)"), &[3.0, 7.0]);
    assert_near(&goal_um(upright, "(9.5 px, 26 px)"), &[2.75, 1.0]);
    // Its rows point along y, so what is lower in the image has greater x.
    let turned = "image { scale: 0.5 um/px, origin: (10 px, 20 px) } at pose(3 um, 4 um, 90 deg)";
    assert_near(&goal_um(turned, "(14 px, 20 px)"), &[3.0, 6.0]);
    assert_near(&goal_um(turned, "(10 px, 26 px)"), &[6.0, 4.0]);
    // The same image seen from behind.
    let mirrored = "image { scale: 0.5 um/px, origin: (10 px, 20 px), mirrored: true } at pose(3 um, 4 um, 90 deg)";
    assert_near(&goal_um(mirrored, "(14 px, 20 px)"), &[3.0, 6.0]);
    assert_near(&goal_um(mirrored, "(10 px, 26 px)"), &[0.0, 4.0]);
    // 30 deg: 8 px along the rows are 4 um, and 2 px up are 1 um across.
    let (sin, cos) = (0.5, 0.75_f64.sqrt());
    let oblique = "image { scale: 500 nm/px } at pose(1 um, 2 um, 30 deg)";
    assert_near(&goal_um(oblique, "(8 px, -2 px)"), &[1.0 + 4.0 * cos - sin, 2.0 + 4.0 * sin + cos]);
    // Lengths stay lengths.
    assert_near(&goal_um(oblique, "(8 um, 2 um)"), &[8.0, 2.0]);
}

#[test]
fn headings_turn_as_the_image_shows_them() {
    let pose = |image: &str| {
        let scene = format!(
            "frame top : {image}\n  obstacle bar : box {{ size: (1 um, 0.2 um) }} at pose(14 px, 14 px, 20 deg)"
        );
        let order =
            order(&format!("{BOT}scene bench {{\n  {scene}\n}}\ntask go on bot in bench {{ move to (0, 0) }}\n"));
        let DimibotObstacleBody::Solid { pose: Pose { x_um, y_um, heading_rad }, .. } = order.obstacles[0].body else {
            panic!("a solid")
        };
        [x_um, y_um, heading_rad.to_degrees()]
    };
    assert_near(&pose("image { scale: 0.5 um/px, origin: (10 px, 20 px) } at (3 um, 4 um)"), &[5.0, 7.0, 20.0]);
    let turned = "image { scale: 0.5 um/px, origin: (10 px, 20 px) } at pose(7 um, 4 um, 90 deg)";
    assert_near(&pose(turned), &[4.0, 6.0, 110.0]);
    let mirrored = "image { scale: 0.5 um/px, origin: (10 px, 20 px), mirrored: true } at pose(3 um, 4 um, 90 deg)";
    assert_near(&pose(mirrored), &[6.0, 6.0, 70.0]);
}

#[test]
fn an_outline_is_drawn_in_the_image() {
    let scene = |points: &str| {
        let image = "frame top : image { scale: 0.5 um/px, origin: (0 px, 24 px) }";
        let text = format!("obstacle rim : polygon {{ points: [{points}] }}");
        format!("{BOT}scene bench {{\n  {image}\n  {text}\n}}\ntask go on bot in bench {{ move to (0, 0) }}\n")
    };
    let order = order(&scene("(8 px, 8 px), (12 px, 8 px), (8 px, 12 px)"));
    let DimibotObstacleBody::Solid { shape: Shape::Polygon { points_um }, .. } = &order.obstacles[0].body else {
        panic!("a polygon")
    };
    assert_near(&points_um.concat(), &[4.0, 8.0, 6.0, 8.0, 4.0, 6.0]);
    let moved = scene("(8 px, 8 px), (12 px, 8 px), (8 px, 12 px)").replace("12 px)] }", "12 px)] } at (1 um, 1 um)");
    assert_eq!(build(&moved).codes, ["E0570"]);
}

#[test]
fn what_cannot_be_is_said() {
    let codes = |scene: &str, task: &str| {
        build(&format!("{BOT}scene bench {{\n{scene}\n}}\ntask go on bot in bench {{ {task} }}\n")).codes
    };
    assert_eq!(codes("", "move to (4 px, 4 px)"), ["E0570"]);
    assert_eq!(codes("obstacle bead : disc { radius: 1 um } at (4 px, 4 px)", "move to (0, 0)"), ["E0570"]);
    let image = "frame top : image { scale: 0.5 um/px, origin: (0 px, 24 px) }";
    assert_eq!(codes(image, "move to (4 px, 4 px)"), [""; 0]);
    assert_eq!(codes(image, "visit [(4 px, 4 px), (6 um, 3 um), (3, 9)]"), [""; 0]);
    assert_eq!(codes(image, "start at (4 px, 4 px), move to (3, 9)"), [""; 0]);
    assert_eq!(codes(image, "move to (4 px, 40 px)"), ["E0501"]);
    assert_eq!(codes(&format!("{image}\nframe side : image {{ scale: 1 um/px }}"), "move to (3, 9)"), ["E0571"]);
    assert_eq!(codes(&format!("for i in 0..1 {{ {image} }}"), "move to (3, 9)"), ["E0571"]);
    assert_eq!(codes("frame top : disc { radius: 1 um }", "move to (3, 9)"), ["E0560"]);
    assert_eq!(codes("frame top : image { scale: 1 um/px } at (3 px, 3 px)", "move to (3, 9)"), ["E0560"]);
    let wrong = |fields: &str| codes(&format!("frame top : image {{ {fields} }}"), "move to (4 px, 4 px)");
    assert_eq!(wrong("scale: 0 um/px"), wrong("scale: -1 um/px"));
    assert_eq!(wrong("scale: 0 um/px").len(), 1);
    assert_eq!(wrong("").len(), 1);
    assert_eq!(wrong("scale: 1 um").len(), 1);
    assert_eq!(wrong("scale: 1 um/px, origin: (1 um, 1 um)").len(), 1);
    let home =
        "use std.dimibot\ndevice bot : dimibot.femto_st { home: (3 px, 3 px) }\ntask go on bot { move to (3, 9) }\n";
    assert_eq!(build(home).codes, ["E0570"]);
}

/// A scene based on another one inherits its image or has its own.
#[test]
fn images_are_inherited() {
    let text = |own: &str| {
        format!(
            "{BOT}scene bench {{\n  frame top : image {{ scale: 0.5 um/px, origin: (0 px, 24 px) }}\n}}\n\
             scene other : bench {{\n{own}}}\ntask go on bot in other {{ move to (8 px, 16 px) }}\n"
        )
    };
    let goal = |text: &str| match &order(text).steps[0].action {
        DimibotAction::Move(stops) => stops[0].asked,
        other => panic!("{other:?}"),
    };
    assert_eq!(goal(&text("")), Asked::Place([4.0, 4.0]));
    assert_eq!(
        goal(&text("  frame near : image { scale: 0.25 um/px, origin: (0 px, 24 px) }\n")),
        Asked::Place([2.0, 2.0])
    );
}

/// A random image with the projection of places into it: the inverse of the compiler's map, by another method (complex
/// numbers).
struct Shown {
    text: String,
    at: [f64; 2],
    heading_deg: f64,
    origin: [f64; 2],
    scale: f64,
    mirrored: bool,
}

impl Shown {
    fn random(random: &mut Random) -> Shown {
        let at = [random.thousandths(-20.0, 20.0), random.thousandths(-20.0, 20.0)];
        let origin = [random.thousandths(-800.0, 800.0), random.thousandths(-800.0, 800.0)];
        let (heading_deg, scale, mirrored) =
            (random.thousandths(-360.0, 360.0), random.thousandths(0.01, 2.0), random.below(2) == 0);
        let text = format!(
            "  frame top : image {{ scale: {scale} um/px, origin: ({} px, {} px), mirrored: {mirrored} }} at pose({} um, {} um, {heading_deg} deg)\n",
            origin[0], origin[1], at[0], at[1]
        );
        Shown { text, at, heading_deg, origin, scale, mirrored }
    }

    /// The pixel that shows a place of the scene.
    fn pixel(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let (re, im) = ((x - self.at[0]) / self.scale, (y - self.at[1]) / self.scale);
        let back = num(-self.heading_deg);
        let (along, up) = (re * back.0 - im * back.1, re * back.1 + im * back.0);
        [self.origin[0] + along, self.origin[1] + if self.mirrored { up } else { -up }]
    }

    /// The heading in the image of a heading in the scene, in degrees.
    fn heading_deg(&self, heading_deg: f64) -> f64 {
        let turned = heading_deg - self.heading_deg;
        if self.mirrored { -turned } else { turned }
    }
}

fn num(heading_deg: f64) -> (f64, f64) {
    (heading_deg.to_radians().cos(), heading_deg.to_radians().sin())
}

/// The same program in lengths and in pixels.
fn written_twice(random: &mut Random) -> [String; 2] {
    let shown = Shown::random(random);
    let mut scenes = [String::new(), shown.text.clone()];
    let place = |[x, y]: [f64; 2], unit: &str| format!("({x:.10} {unit}, {y:.10} {unit})");
    let pose =
        |[x, y]: [f64; 2], turn: f64, unit: &str| format!("pose({x:.10} {unit}, {y:.10} {unit}, {turn:.10} deg)");
    let mut put = |text: &str, at: [f64; 2], turn: f64| {
        scenes[0] += &format!("  {text} at {}\n", pose(at, turn, "um"));
        scenes[1] += &format!("  {text} at {}\n", pose(shown.pixel(at), shown.heading_deg(turn), "px"));
    };
    let stand = [random.thousandths(-2.0, 2.0), random.thousandths(-2.0, 2.0)];
    if random.below(2) == 0 {
        put("frame bot", stand, random.thousandths(-20.0, 20.0));
    }
    for at in 0..3 {
        let (size, middle) =
            (random.thousandths(0.2, 3.0), [random.thousandths(0.0, 12.0), random.thousandths(0.0, 12.0)]);
        put(&format!("obstacle o{at} : box {{ size: ({size} um, 0.6 um) }}"), middle, random.thousandths(0.0, 180.0));
    }
    let places: Vec<[f64; 2]> =
        (0..3).map(|_| [random.thousandths(1.0, 11.0), random.thousandths(1.0, 11.0)]).collect();
    let steps = |unit: &str, seen: &dyn Fn([f64; 2]) -> [f64; 2]| {
        let [a, b, c] = [0, 1, 2].map(|index: usize| place(seen(places[index]), unit));
        format!("move to {a}, visit [{b}, {c}]")
    };
    let steps = [steps("um", &|at| at), steps("px", &|at| shown.pixel(at))];
    [0, 1].map(|way| format!("{BOT}scene bench {{\n{}}}\ntask go on bot in bench {{ {} }}\n", scenes[way], steps[way]))
}

#[test]
fn programs_in_pixels_and_in_lengths_are_one() {
    let (mut planned, mut refused) = (0, 0);
    for case in 0..cases(40) {
        let [lengths, pixels] = written_twice(&mut Random::new(0x0CA3_0000 + case));
        let (one, other) = (build(&lengths), build(&pixels));
        let codes =
            |built: &Built| built.codes.iter().filter(|code| code.starts_with('E')).copied().collect::<Vec<_>>();
        assert_eq!(codes(&one), codes(&other), "{lengths}\n{pixels}\n{:?} {:?}", one.titles, other.titles);
        let (Some(one), Some(other)) = (one.schedules.first(), other.schedules.first()) else {
            refused += 1;
            continue;
        };
        let (one, other) = (one.schedule(), other.schedule());
        assert_eq!(
            (one.plans[0].cost, &one.plans[0].states),
            (other.plans[0].cost, &other.plans[0].states),
            "{pixels}"
        );
        for (step, seen) in one.steps.iter().zip(&other.steps) {
            assert_eq!(step.reached.len(), seen.reached.len());
            assert!(step.reached.iter().zip(&seen.reached).all(|(a, b)| a.is_near(b, 1e-6)), "{pixels}");
        }
        planned += 1;
    }
    println!("{planned} planned, {refused} refused, alike");
    assert!(planned > 5 && refused > 2, "{planned} {refused}");
}

#[test]
fn microrobots_stand_and_drive_by_their_image_too() {
    let program = |image: &str, poses: [String; 4]| {
        let [one, two, three, goal] = poses;
        format!(
            "use std.microrobots\ndevice fleet : microrobots.bed {{\n  robots: table {{\n\
             robot | snap_down [V] | release [V] | turning_radius [um] | speed [um/s]\n\
             D1 | 110 | 20 | 162 | 200\nD2 | 122 | 33 | 160 | 195\nD3 | 134 | 46 | 165 | 205\n  }}\n  margin: 4 V\n}}\n\
             scene field {{\n{image}  robot D1 at {one}\n  robot D2 at {two}\n  robot D3 at {three}\n}}\n\
             task go on fleet in field {{ drive D3 to {goal} }}\n"
        )
    };
    let poses = [[0.0, 0.0, 90.0], [3000.0, 200.0, 0.0], [1500.0, 2800.0, 180.0], [600.0, 2000.0, 30.0]];
    let lengths = poses.map(|[x, y, heading]| format!("pose({x} um, {y} um, {heading} deg)"));
    let mut random = Random::new(0x0CA4);
    for _ in 0..4 {
        let shown = Shown::random(&mut random);
        let seen = poses.map(|[x, y, heading]| {
            let [u, v] = shown.pixel([x, y]);
            format!("pose({u:.10} px, {v:.10} px, {:.10} deg)", shown.heading_deg(heading))
        });
        let [one, other] = [build(&program("", lengths.clone())), build(&program(&shown.text, seen))];
        assert_eq!(one.codes, other.codes, "{:?}", other.titles);
        assert_eq!(one.schedules.len(), 1, "{:?}", one.titles);
        let [one, other] = [&one, &other].map(|built| &built.schedules[0].schedule().steps[0].reached[0]);
        assert!(one.is_near(other, 1e-3), "{one} {other}");
    }
}
