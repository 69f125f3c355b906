//! Two outlets, each with its own condition.

use sphecs::Simulation;

use crate::flow;

/// Channel of ten particles across with a side branch of the same width, at Re = 100.
const JUNCTION: &str = r#"Scene(
    title: "A junction", dimensions: 2, spacing: 0.01, smoke: 0.01,
    constants: {"H": 0.05, "u": 0.1},
    fluid: (density: 1000.0, viscosity: 1.0e-4, sound_speed: 2.0),
    domain: Union([
        Box(min: (0.0, "-H"), max: (0.5, "H")),
        Box(min: (0.15, 0.0), max: (0.25, 0.25)),
    ]),
    initial: (velocity: ("1.5*u*(1 - y^2/H^2)*(abs(y) < H)*(1 - 0.5*(x > 0.15))", "0.5*u*(y > H)")),
    inlets: [(at: (0.0, 0.0), towards: (1.0, 0.0), velocity: Normal("1.5*u*(1 - y^2/H^2)"))],
    outlets: [
        (at: (0.5, 0.0), towards: (1.0, 0.0), condition: WaveEquation()),
        (at: (0.2, 0.25), towards: (0.0, 1.0), condition: WaveEquation()),
    ],
    time: (end: 20.0), output: (every: 1.0), reference: (velocity: "u", length: "2*H"),
)"#;

/// Returns the outflow through each outlet from 3 to 9 s, over the inflow.
fn shares(simulation: &mut Simulation, what: &str) -> [f64; 2] {
    let count = |simulation: &Simulation| {
        let ledger = simulation.ledger();
        assert!(ledger.balances(), "{what}: {ledger:?}");
        let net = |out: u64, back: u64| out as f64 - back as f64;
        let left = [0, 1].map(|outlet| net(ledger.left[outlet], ledger.left_back[outlet]));
        (net(ledger.entered[0], ledger.entered_back[0]), left)
    };
    simulation.run_until(3.0).unwrap_or_else(|stop| panic!("{what}: {stop}"));
    let (entered_before, left_before) = count(simulation);
    simulation.run_until(9.0).unwrap_or_else(|stop| panic!("{what}: {stop}"));
    let (entered, left) = count(simulation);
    assert_eq!(simulation.monitor_row().through_walls, 0, "{what}");
    [0, 1].map(|outlet| (left[outlet] - left_before[outlet]) / (entered - entered_before))
}

/// Returns the changes that swap the order of the outlets.
fn swapped<'a>(scheme: &'a str, straight: &'a str, aside: &'a str) -> [(&'a str, &'a str); 7] {
    [
        ("scheme", scheme),
        ("outlets.0.at", "(0.2, 0.25)"),
        ("outlets.0.towards", "(0.0, 1.0)"),
        ("outlets.0.condition", aside),
        ("outlets.1.at", "(0.5, 0.0)"),
        ("outlets.1.towards", "(1.0, 0.0)"),
        ("outlets.1.condition", straight),
    ]
}

/// The outflow through both outlets equals the inflow, and their order in the scene has no effect.
/// An outlet with a prescribed velocity, 0.6 of that of the inflow, takes its share.
#[test]
fn two_outlets_with_different_conditions_share_the_flow() {
    let pairs = [
        ("WaveEquation()", "Hybrid()", None),
        ("Hybrid()", "WaveEquation(pressure: Reference(0.0))", None),
        ("Characteristic(velocity: 0.06, pressure: 0.0)", "WaveEquation()", Some(0.6)),
        ("FlowShare(share: 0.6)", "WaveEquation()", Some(0.6)),
        ("FlowShare(share: 0.6)", "Pressure(value: 0.0)", Some(0.6)),
    ];
    // With the other scheme the pair whose order matters, and a prescribed share at a pressure.
    let of_edac = [pairs[1], pairs[4]];
    for (scheme, pairs) in [("Wcsph()", &pairs[..]), ("EdacTvf()", &of_edac)] {
        for &(straight, aside, expected) in pairs {
            let what = format!("{scheme}, {straight} and {aside}");
            let sets =
                [("scheme", scheme), ("outlets.0.condition", straight), ("outlets.1.condition", aside)];
            let found = shares(&mut flow(JUNCTION, &sets), &what);
            println!("{what}: {found:?}");
            let all = found[0] + found[1];
            // A column is ten of some six hundred particles.
            assert!((all - 1.0).abs() < 0.03, "{what}: {all} of what enters leaves");
            assert!(found.iter().all(|share| *share > 0.2), "{what}: {found:?}");
            if let Some(expected) = expected {
                assert!((found[0] - expected).abs() < 0.02, "{what}: {found:?}");
            } else if straight == "Hybrid()" {
                let [aside, straight] = shares(&mut flow(JUNCTION, &swapped(scheme, straight, aside)), &what);
                assert_eq!(found, [straight, aside], "{what}, named the other way round");
            }
        }
    }
}
