"""The runs of the comparison: one table for the full manifest, one for the quick one.

Keys of a manifest come from the names of this table, not from the spellings of the options. When an
option or a field of a scene gets a new name, change it in this table and keep the key. For a build
that has another spelling than the table, give `--rename TABLE=BUILD`.
"""

import re
from dataclasses import dataclass, field
from pathlib import Path

STEPS = 300
QUICK_STEPS = 15
PRECISIONS = ("F32", "F64")


@dataclass
class Case:
    """A scene with settings."""

    name: str
    scene: str
    settings: dict[str, str] = field(default_factory=dict)
    steps: int = STEPS
    precisions: tuple[str, ...] = PRECISIONS
    every_set: bool = True  # with every instruction set, or with the widest alone
    resumed_at: int | None = None  # stop at this step first, then resume


# Steps of the full manifest where 300 would take minutes for a single run.
FEWER_STEPS = {"square_bend": 100, "duct": 100, "duct3d": 150}

SCHEMES = {"Wcsph": "Wcsph()", "EdacTvf": "EdacTvf()"}


def own_scheme(text: str) -> str:
    """The scheme of a scene's text."""
    found = re.search(r"^\s*scheme:\s*(\w+)", text, re.MULTILINE)
    return found.group(1) if found else "Wcsph"


def scenes(root: Path, folder: str, **options) -> list[Case]:
    """Each scene of a folder with its own scheme and with the other."""
    cases = []
    for path in sorted((root / folder).glob("*.ron")):
        steps = options.get("steps") or FEWER_STEPS.get(path.stem, STEPS)
        own = own_scheme(path.read_text(encoding="utf-8"))
        for scheme, text in SCHEMES.items():
            settings = {} if scheme == own else {"scheme": text}
            extra = {key: value for key, value in options.items() if key != "steps"}
            name = f"{folder}/{path.stem}/{scheme}"
            cases.append(Case(name, f"{folder}/{path.name}", settings, steps, **extra))
    return cases


# The periodic boxes of `sphecs bench` with fewer particles: written to a file of this text.
BOX = """Scene(
    title: "Box", dimensions: {dimensions}, spacing: 0.01, smoke: 0.01,
    constants: {{ "k": "4*pi/{edge}" }},
    fluid: (density: 1000.0, viscosity: 1.0e-6, sound_speed: 10.0),
    scheme: {scheme},
    domain: Box(min: ({zeros}), max: ({edges})), periodic: [{axes}], walls: None,
    fill: Lattice(jitter: 0.1),
    initial: (velocity: ({velocity})),
    time: (end: 100.0), output: (every: 0.05),
)
"""
BOX_SCHEMES = {
    "laminar": "Wcsph(smoothing_ratio: {ratio})",
    "sps": "Wcsph(smoothing_ratio: {ratio}, viscosity: Sps())",
    "quintic": "Wcsph(kernel: QuinticSpline, smoothing_ratio: 1.2)",
    "edac": "EdacTvf(smoothing_ratio: 1.2)",
}


def box_text(dimensions: int, count: int, terms: str) -> str:
    """The scene of a box with a given number of particles along each edge."""
    edge = round(count * 0.01, 6)
    velocity = ('"sin(k*y)"', '"cos(k*x)"') if dimensions == 2 else ('"sin(k*y)"', '"cos(k*z)"', '"sin(k*x)"')
    return BOX.format(
        dimensions=dimensions,
        edge=edge,
        scheme=BOX_SCHEMES[terms].format(ratio=1.33 if dimensions == 2 else 2.02),
        zeros=", ".join(["0.0"] * dimensions),
        edges=", ".join([str(edge)] * dimensions),
        axes=", ".join(['"x"', '"y"', '"z"'][:dimensions]),
        velocity=", ".join(velocity),
    )


def boxes(plane: int, space: int, steps_plane: int, steps_space: int) -> list[Case]:
    """The boxes, by their particles along an edge in 2D and 3D."""
    return [
        Case(f"box/{dimensions}d/{terms}", f"box:{dimensions}:{count}:{terms}", {}, steps)
        for dimensions, count, steps in ((2, plane, steps_plane), (3, space, steps_space))
        for terms in BOX_SCHEMES
    ]


def full(root: Path) -> list[Case]:
    """Every scene, the flows of `sphecs bench`, and everything of the quick manifest."""
    # The options of the quick manifest cost little and reach what no scene has.
    shipped = scenes(root, "scenes") + scenes(root, "benches")
    return shipped + boxes(100, 20, STEPS, 60) + options(thorough=True)


def quick(root: Path) -> list[Case]:
    """Few steps of few particles through every part of the engine."""
    fast = scenes(root, "scenes", steps=QUICK_STEPS, every_set=False, precisions=("F64",))
    return [case for case in fast if "constricted_r3" not in case.name] + boxes(24, 12, 10, 4) + options()


PLANE = "scenes/quickstart.ron"
SPACE = "scenes/duct3d.ron"
CYLINDER = "scenes/cylinder_re20.ron"

# Settings of the scheme `Wcsph`, one by one.
WCSPH = {
    "kernel/quintic": "kernel: QuinticSpline",
    "viscosity/printed": "viscosity: Laminar(as_published: true)",
    "viscosity/not_normalised": "viscosity: Laminar(lattice_normalised: false)",
    "viscosity/artificial": "viscosity: Artificial(alpha: 0.05)",
    "viscosity/sps": "viscosity: Sps()",
    "noise_damping": "noise_damping: Reconstructed(alpha: 0.3)",
    "noise_damping_and_sps": "noise_damping: Reconstructed(), viscosity: Sps(), shifting: Local()",
    "shifting/off": "shifting: Off",
    "shifting/fickian": "shifting: Fickian(coefficient: 6.0)",
    "shifting/fickian_removed": "shifting: Fickian(drift_correction: On)",
    "shifting/local": "shifting: Local()",
    "shifting/local_removed": "shifting: Local(coefficient: 20.0, drift_correction: On)",
    "shifting/vacondio": "shifting: Vacondio(beta: 0.01)",
    "shifting/vacondio_diverges": "shifting: Vacondio()",
    "tensile_control_off": "tensile_control: false",
    "integrator/verlet": "integrator: Verlet(corrective_step_every: 7)",
    "integrator/verlet_sps": "integrator: Verlet(), viscosity: Sps()",
}

# Settings of the scheme `EdacTvf`, one by one.
EDAC = {
    "default": "",
    "kernel/wendland": "kernel: WendlandC2",
    "alpha": "alpha: 1.0",
    "background": "background: 0.5",
    "average_pressure_off": "average_pressure: false",
    "not_normalised": "lattice_normalised: false",
    "relaxation": "relaxation: 0.01",
    "printed": "as_published: true",
}

# Walls of quickstart and duct3d. The upper half of the walls moves along x.
PART = {2: 'Box(min: (-1.0, 0.0), max: (1.0, 1.0))', 3: 'Box(min: (-1.0, 0.0, -1.0), max: (1.0, 1.0, 1.0))'}
WALLS = {
    "image_free_slip": "(slip: FreeSlip)",
    "image_wall_function": "(slip: WallFunction)",
    "image_velocity_cap": "(model: Image(velocity_cap: 1.5))",
    "image_mirrored": "(model: Image(pressure: Mirrored))",
    "dummy": "(model: Dummy)",
    "dummy_free_slip": "(model: Dummy, slip: FreeSlip)",
    "dummy_wall_function": "(model: Dummy, slip: WallFunction)",
    "ghost": "(model: Ghost)",
    "ghost_free_slip": "(model: Ghost, slip: FreeSlip)",
    "moving_part": '(parts: [(name: "upper", region: PART, velocity: (MOVING))])',
    "mixed_slip": '(slip: FreeSlip, parts: [(name: "upper", region: PART, slip: WallFunction)])',
}

OUTLETS = {
    "wave_fixed": "WaveEquation(frame: Fixed)",
    "wave_printed": "WaveEquation(transverse: Printed)",
    "wave_consistent": "WaveEquation(transverse: Consistent)",
    "wave_frozen": "WaveEquation(pressure: Frozen)",
    "wave_reference": "WaveEquation(pressure: Reference(5.0))",
    "wave_relaxed": "WaveEquation(pressure: Relaxed(target: 5.0, time: 0.1))",
    "wave_nonreflecting_plane": "WaveEquation(pressure: NonReflecting(target: 2.0, time: 0.05, waves: Plane))",
    "orlanski": "Orlanski()",
    "orlanski_fixed": "Orlanski(frame: Fixed, pressure: Frozen)",
    "do_nothing": "DoNothing",
    "modified_do_nothing": "ModifiedDoNothing()",
    "modified_do_nothing_carried": "ModifiedDoNothing(shown: Carried)",
    "mirror": "Mirror()",
    "mirror_linear": "Mirror(variant: Linear)",
    "mirror_printed": "Mirror(variant: Printed)",
    "characteristic": "Characteristic(velocity: 0.05, pressure: 1.0)",
    "hybrid": "Hybrid()",
    "hybrid_velocity": "Hybrid(velocity: 0.05, pressure: 1.0, steps: 9.0)",
}

# Further settings of quickstart. It starts from rest: crossings within a few steps need a stream.
STREAM = {"initial": '(velocity: (0.1, 0.0), tag: "y > 0")', "inlets.0.velocity": "Normal(0.1)"}
FLOW = {
    "stream": {},
    "no_recycling": {"reservoir": "(recycle: false)"},
    "small_reservoir": {"reservoir": "(particles: 3, when_empty: Grow)"},
    "empty_reservoir": {"reservoir": "(particles: 0, when_empty: Stop)"},
    "inlet_once": {"inlets.0.feed": "Once", "inlets.0.depth": "0.05"},
    "inlet_pressure": {"inlets.0.pressure": "Prescribed(4.0)"},
    "inlet_components": {"inlets.0.velocity": 'Components(("0.1*(1 + 0.3*sin(20*t))", "0.01*y/D"))'},
    "inlet_table": {"inlets.0.velocity": "TimeTable(rows: [(0.0, 0.05), (0.01, 0.1), (0.5, 0.2)])"},
    "inlet_mass_flow": {"inlets.0.velocity": 'MassFlow(rate: 4.0, profile: "1 - 4*y^2/D^2")'},
    "inlet_mass_flux": {"inlets.0.velocity": 'MassFlux(flux: "100*(1 + t)")'},
    "jitter": {"fill": "Lattice(jitter: 0.15)"},
    "body_force": {"body_force": '("0.5*sin(30*x)", "0.2*cos(10*t)*y")'},
    "bodies": {"bodies": '[(part: "walls", velocity: 0.1, area: "d", mean: (0.01, 0.02))]'},
    "bodies_sps": {
        "bodies": '[(part: "upper", about: (0.08, 0.0), velocity: 0.1, area: "d", mean: (0.01, 0.02)), '
        '(part: "walls")]',
        "walls": f'(slip: WallFunction, parts: [(name: "upper", region: {PART[2]})])',
        "scheme": "Wcsph(viscosity: Sps())",
    },
    "probes": {
        "output.probes": '[(name: "point", kind: Point(at: (0.19, 0.0)), sees: Flow, mean: (0.0, 0.02)), '
        '(name: "line", kind: Line(from: (0.15, 0.0), to: ("L", 0.0), count: 9), sees: Flow), '
        '(name: "slanted", kind: Section(at: (0.03, 0.0), normal: (1.0, 0.3)), mean: (0.0, 0.02))]'
    },
}


def options(thorough: bool = False) -> list[Case]:
    """One case for each option of the engine, in 2D and in 3D.

    Schemes and their options run in both precisions with every instruction set in 2D. The rest runs
    in one precision with the widest set, unless it is to be thorough.
    """
    # A frame and rows within the few steps; in 3D coarser than the smoke spacing.
    plane = {"output.every": "0.005", "output.monitor_every": "0.002"}
    space = {"output.every": "0.004", "output.monitor_every": "0.001", "constants.t0": "0.01"}
    short = {"spacing": "0.05", "smoke": "0.05"}
    cases = []

    def add(dimensions, name, settings, precision=None, resumed_at=None):
        precision = PRECISIONS if thorough or precision is None else (precision,)
        common = plane | STREAM if dimensions == 2 else space | short
        scene, steps = (PLANE, 40) if dimensions == 2 else (SPACE, 8)
        every_set = thorough or len(precision) > 1
        name = f"{dimensions}d/{name}"
        cases.append(Case(name, scene, common | settings, steps, precision, every_set, resumed_at))

    for scheme, table in (("Wcsph", WCSPH), ("EdacTvf", EDAC)):
        for name, text in table.items():
            add(2, f"options/{scheme}/{name}", {"scheme": f"{scheme}({text})"})
            add(3, f"options/{scheme}/{name}", {"scheme": f"{scheme}({text})"}, "F32")
    for scheme, text in (SCHEMES | {"Sps": "Wcsph(viscosity: Sps())"}).items():
        for name, walls in WALLS.items():
            # Version 0.1.0 ends with a panic for dummy walls with sub-particle stress.
            if scheme == "Sps" and name.startswith("dummy"):
                continue
            for dimensions, precision, moving in ((2, "F32", "0.05, 0.0"), (3, "F64", "0.05, 0.0, 0.0")):
                walls_text = walls.replace("PART", PART[dimensions]).replace("MOVING", moving)
                add(dimensions, f"walls/{scheme}/{name}", {"scheme": text, "walls": walls_text}, precision)
    for scheme, text in SCHEMES.items():
        for name, condition in OUTLETS.items():
            settings = {"scheme": text, "outlets.0.condition": condition}
            add(2, f"outlets/{scheme}/{name}", settings, "F64")
            add(3, f"outlets/{scheme}/{name}", settings, "F32")
        for name, settings in FLOW.items():
            precision = "F64" if scheme == "Wcsph" else "F32"
            add(2, f"flow/{scheme}/{name}", {"scheme": text} | settings, precision)
        add(2, f"resumed/{scheme}", {"scheme": text}, "F32", resumed_at=17)
        add(3, f"resumed/{scheme}", {"scheme": text}, "F64", resumed_at=3)
    for precision, (scheme, text) in zip(PRECISIONS, SCHEMES.items()):
        settings = {"scheme": text, "output.every": "0.2", "output.monitor_every": "0.05"}
        precisions = PRECISIONS if thorough else (precision,)
        case = Case(f"2d/cylinder/{scheme}", CYLINDER, settings, 20, precisions, thorough)
        cases.append(case)
    return cases
