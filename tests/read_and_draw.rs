//! Results are read, drawn and exported, packed or not, in 2D and in 3D.

use std::path::Path;
use std::process::Command;

use sphecs_output::folder::RunFolder;
use sphecs_output::frame::Frame;
use sphecs_output::header::Header;
use sphecs_output::info;
use sphecs_output::picture::all_frames::render_all;
use sphecs_output::picture::{Field, RenderOptions, Slice, render};
use sphecs_output::probes::ProbeSet;
use sphecs_output::results::Results;
use sphecs_output::summary::{Status, Summary};
use sphecs_output::vtk::export_vtu;

const SPACING: f64 = 0.05;

/// Returns a channel of 40 × 10 (× 6) particles with a parabolic flow; the last slots are in the
/// reservoir.
fn channel(dimensions: usize, time: f64) -> Frame {
    let layers = if dimensions == 3 { 6 } else { 1 };
    let inside = 40 * 14 * layers;
    let mut frame = Frame::absent(inside + 5);
    frame.zone[inside..].fill(4);
    for slot in 0..inside {
        let (column, row, layer) = (slot % 40, slot / 40 % 14, slot / 560);
        let place = [column, row, layer].map(|k| (k as f64 + 0.5) * SPACING);
        let y = place[1] / (14.0 * SPACING) * 2.0 - 1.0;
        let wall = !(2..12).contains(&row);
        frame.zone[slot] = if wall { 1 } else { 0 };
        for (axis, &x) in place.iter().take(dimensions).enumerate() {
            frame.position[axis][slot] = x;
        }
        if dimensions == 2 {
            frame.position[2][slot] = 0.0;
        }
        frame.velocity[0][slot] = (1.0 - y * y) as f32;
        frame.velocity[1][slot] = time as f32;
        frame.velocity[2][slot] = 0.0;
        frame.density[slot] = 1000.0;
        frame.pressure[slot] = place[0] as f32;
        frame.tag[slot] = column as f32;
        frame.passage[slot] = row as u32;
    }
    frame.time = time;
    frame.step = (1000.0 * time) as u64;
    frame.time_step = 1e-3;
    frame
}

fn run(path: &Path, dimensions: usize) -> RunFolder {
    let first = channel(dimensions, 0.0);
    let header = Header {
        scene: "channel".to_owned(),
        title: "Plane channel".to_owned(),
        text: "Scene()".to_owned(),
        dimensions,
        spacing: SPACING,
        smoothing_length: 1.5 * SPACING,
        bounds: first.bounds().expect("particles"),
        ..Header::default()
    };
    let mut run = RunFolder::create(path, false, &header, &ProbeSet::default()).expect("a run folder");
    for time in [0.0, 0.1, 0.25] {
        run.submit(channel(dimensions, time)).expect("accepted");
    }
    run
}

/// Asserts that walls keep their position and all other slots are bitwise identical.
fn assert_same(found: &Frame, wanted: &Frame) {
    assert_eq!((found.time, found.step, found.time_step), (wanted.time, wanted.step, wanted.time_step));
    assert_eq!(found.zone, wanted.zone);
    for slot in 0..wanted.len() {
        for axis in 0..3 {
            let places = (found.position[axis][slot], wanted.position[axis][slot]);
            assert!(
                places.0 == places.1 || places.0.is_nan() && places.1.is_nan(),
                "slot {slot}: {places:?}"
            );
        }
        if wanted.zone[slot] == 0 {
            assert_eq!(found.velocity[0][slot], wanted.velocity[0][slot]);
            assert_eq!(found.velocity[1][slot], wanted.velocity[1][slot]);
            assert_eq!(found.pressure[slot], wanted.pressure[slot]);
            assert_eq!(found.passage[slot], wanted.passage[slot]);
            assert_eq!(found.tag[slot], wanted.tag[slot]);
        }
    }
}

#[test]
fn frames_read_back_from_journal_and_from_packed_file() {
    for dimensions in [2, 3] {
        let parent = tempfile::tempdir().expect("a folder");
        let path = parent.path().join("run");
        let run = run(&path, dimensions);
        while run.frames_written() < 3 {
            std::thread::yield_now();
        }
        let journal = Results::open(&path).expect("a run");
        assert!(!journal.is_packed());
        run.finish(Summary { status: Status::Completed, ..Summary::default() }).expect("ended");
        let packed = Results::open(&path).expect("a run");
        assert!(packed.is_packed());
        // The first was opened before its journal was removed.
        for results in [&journal, &packed] {
            assert_eq!(results.times(), [0.0, 0.1, 0.25]);
            for (index, time) in results.times().into_iter().enumerate() {
                assert_same(&results.frame(index).expect("a frame"), &channel(dimensions, time));
            }
        }
        assert_eq!(packed.nearest(0.14).expect("a frame"), 1);
        assert!(packed.frame(3).expect_err("refused").to_string().contains("0 to 2"));
        let text = info::describe(&packed).expect("described");
        assert!(
            text.contains("Plane channel") && text.contains("completed") && text.contains("3 from 0 s"),
            "{text}"
        );
    }
}

#[test]
fn picture_shows_field_and_walls() {
    for dimensions in [2, 3] {
        let parent = tempfile::tempdir().expect("a folder");
        let path = parent.path().join("run");
        run(&path, dimensions).finish(Summary::default()).expect("ended");
        let results = Results::open(&path).expect("a run");
        let picture = parent.path().join("flow.png");
        for field in Field::ALL {
            let options = RenderOptions { field, width: 640, ..RenderOptions::default() };
            match render(&results, Some(0.11), &options, &picture) {
                Ok(time) => assert_eq!(time, 0.1),
                Err(error) => assert!(field == Field::W && dimensions == 2, "{}: {error}", field.name()),
            }
        }
        let options = RenderOptions { width: 640, range: Some((0.0, 1.0)), ..RenderOptions::default() };
        render(&results, None, &options, &picture).expect("drawn");
        let image = image::open(&picture).expect("a picture").to_rgb8();
        assert_eq!(image.width(), 640);
        let grey = |pixel: &image::Rgb<u8>| pixel.0 == [0x9a, 0x9f, 0xa6];
        let walls = image.pixels().filter(|pixel| grey(pixel)).count() as f64;
        let field = image.pixels().filter(|pixel| {
            let [r, g, b] = pixel.0.map(i32::from);
            (r - g).abs().max((g - b).abs()) > 30
        });
        // Four layers of wall on ten of fluid; the colour bar adds a few per cent to the fluid.
        let ratio = walls / field.count() as f64;
        assert!((0.33..0.41).contains(&ratio), "walls to fluid {ratio} in {dimensions}D");
    }
}

#[test]
fn series_has_a_picture_and_a_grid_per_frame() {
    let parent = tempfile::tempdir().expect("a folder");
    let path = parent.path().join("run");
    run(&path, 3).finish(Summary::default()).expect("ended");
    let results = Results::open(&path).expect("a run");
    let options =
        RenderOptions { width: 320, slice: Some(Slice { axis: 0, at: None }), ..RenderOptions::default() };
    let mut counted = Vec::new();
    let pictures = render_all(&results, &options, &parent.path().join("flow.png"), |done, all| {
        counted.push((done, all))
    })
    .expect("drawn");
    assert_eq!(counted, [(1, 3), (2, 3), (3, 3)]);
    assert!(pictures.iter().all(|path| path.exists()) && pictures[2].ends_with("flow-0002.png"));

    let export = export_vtu(&results, &path.join("vtk"), |_, _| {}).expect("exported");
    let text = std::fs::read_to_string(&export.series).expect("read");
    assert_eq!((text.matches("<DataSet").count(), export.removed), (3, 0));
    assert!(path.join("vtk/particles-00002.vtu").exists() && path.join("vtk/walls.vtu").exists());
}

/// The end of a longer series would be taken for that of the shorter one written over it.
#[test]
fn nothing_of_a_longer_series_stays_beside_a_shorter_one() {
    let parent = tempfile::tempdir().expect("a folder");
    let (path, vtk) = (parent.path().join("run"), parent.path().join("vtk"));
    run(&path, 3).finish(Summary::default()).expect("ended");
    let results = Results::open(&path).expect("a run");
    export_vtu(&results, &vtk, |_, _| {}).expect("exported");
    // Two more frames, and files that the export did not write.
    for name in ["particles-00003.vtu", "particles-00004.vtu"] {
        std::fs::copy(vtk.join("particles-00002.vtu"), vtk.join(name)).expect("copied");
    }
    let mine = ["particles-00005.vtu", "particles-6.vtu", "particles-00007.vtu.bak"];
    for name in mine {
        std::fs::write(vtk.join(name), "<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\">")
            .expect("written");
    }
    let export = export_vtu(&results, &vtk, |_, _| {}).expect("exported");
    assert_eq!(export.removed, 2);
    assert!(!vtk.join("particles-00003.vtu").exists() && !vtk.join("particles-00004.vtu").exists());
    assert!(vtk.join("particles-00002.vtu").exists() && mine.iter().all(|name| vtk.join(name).exists()));

    let picture = parent.path().join("flow.png");
    let longer = parent.path().join("flow-0003.png");
    std::fs::write(&longer, "mine").expect("written");
    let options = RenderOptions { width: 320, ..RenderOptions::default() };
    let refused = render_all(&results, &options, &picture, |_, _| {}).expect_err("refused").to_string();
    assert!(refused.contains("longer series") && refused.contains("3 frames"), "{refused}");
    assert!(!parent.path().join("flow-0000.png").exists() && longer.exists());
}

#[test]
fn requests_that_do_not_match_the_run_are_refused() {
    let parent = tempfile::tempdir().expect("a folder");
    let path = parent.path().join("run");
    run(&path, 3).finish(Summary::default()).expect("ended");
    let results = Results::open(&path).expect("a run");
    let picture = parent.path().join("flow.png");
    let refused =
        |options: RenderOptions| render(&results, None, &options, &picture).expect_err("refused").to_string();
    let outside =
        refused(RenderOptions { slice: Some(Slice { axis: 2, at: Some(7.0) }), ..RenderOptions::default() });
    assert!(outside.contains("from 0.025 to 0.275 m"), "{outside}");
    let reversed = refused(RenderOptions { range: Some((1.0, 0.0)), ..RenderOptions::default() });
    assert!(reversed.contains("smaller"), "{reversed}");
    // The frames are at 0, 0.1 and 0.25 s.
    let at = |time| render(&results, Some(time), &RenderOptions::default(), &picture);
    assert_eq!(at(0.39).expect("drawn"), 0.25);
    for time in [99.0, 0.41, -0.16] {
        let late = at(time).expect_err("refused").to_string();
        assert!(late.contains("frames are from 0 to 0.25 s"), "{late}");
    }
    assert!(Results::open(parent.path()).expect_err("refused").to_string().contains("is not a run"));
}

/// Runs the program in a folder and returns what it printed, and its exit code.
fn sphecs(folder: &Path, line: &str) -> (String, Option<i32>) {
    let output = Command::new(env!("CARGO_BIN_EXE_sphecs"))
        .args(line.split(' '))
        .current_dir(folder)
        .output()
        .expect("the program");
    let text = [output.stdout, output.stderr].concat();
    (String::from_utf8_lossy(&text).into_owned(), output.status.code())
}

/// Asserts that a command line ends well.
fn done(folder: &Path, line: &str) -> String {
    let (text, code) = sphecs(folder, line);
    assert_eq!(code, Some(0), "`{line}` gave:\n{text}");
    text
}

/// Asserts that a command line is refused with a word.
fn refused(folder: &Path, line: &str, word: &str) {
    let (text, code) = sphecs(folder, line);
    // The lines of a message are wrapped.
    let text = text.split_whitespace().filter(|part| *part != "│").collect::<Vec<_>>().join(" ");
    assert!(code != Some(0) && text.contains(word), "`{line}` gave:\n{text}");
}

#[test]
fn command_line_draws_means_lines_movies_and_plots() {
    let parent = tempfile::tempdir().expect("a folder");
    let folder = parent.path();
    let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/quickstart.ron");
    let scene = scene.display();
    done(folder, &format!("run {scene} --smoke --until 0.3 --set output.every=0.1 --out run -q"));
    let size = |name: &str| std::fs::metadata(folder.join(name)).map_or(0, |data| data.len());

    done(folder, "render run --width 600 -o plain.png");
    for option in ["--arrows", "--streamlines=12", "--contours", "--box 0.05,0.12,-0.02,0.02"] {
        done(folder, &format!("render run --width 600 {option} -o lines.png"));
        assert!(size("lines.png") > 0 && size("lines.png") != size("plain.png"), "{option}");
    }
    let text = done(folder, "render run --mean 0.1,9 --streamlines --field u --width 600 -o mean.pdf");
    assert!(text.contains("mean of 0.1 to 0.3"), "{text}");
    assert!(size("mean.pdf") > 1000);
    let text = done(folder, "render run --movie flow.gif --width 320 --field vorticity");
    assert!(text.contains("4 frames"), "{text}");
    let movie = std::fs::read(folder.join("flow.gif")).expect("read");
    assert!(movie.starts_with(b"GIF89a") && movie.ends_with(b";"));

    done(folder, "plot run monitor.kinetic_energy probes.gap.mass_flow -o series.svg");
    let plot = std::fs::read_to_string(folder.join("series.svg")).expect("read");
    for word in [
        "Channel with a constriction",
        "kinetic_energy [",
        "gap.mass_flow [",
        "J/m]",
        "kg/(m s)]",
        "time [s]",
    ] {
        assert!(plot.contains(word), "{word}");
    }
    done(folder, "plot run probes.axis.u --time 0.1,0.3 -o profiles.svg");
    let plot = std::fs::read_to_string(folder.join("profiles.svg")).expect("read");
    assert!(plot.contains("x [m]") && plot.matches("t = 0.").count() == 2, "{plot}");
    done(folder, &format!("run {scene} --smoke --until 0.2 --out other -q"));
    done(folder, "plot run other probes.axis.u --mean 0.1,0.2 -o runs.png");
    assert!(done(folder, "plot run").contains("probes.axis.pressure"));

    refused(folder, "plot run monitor.kinetic -o a.svg", "did you mean `monitor.kinetic_energy`?");
    refused(folder, "plot run monitor.kinetic -o a.svg", "probes.gap.mass_flow");
    refused(folder, "plot run monitor.kinetic_energy probes.axis.u -o a.svg", "in two plots");
    refused(folder, "plot run monitor.kinetic_energy --mean 0.1,0.2", "--over");
    refused(folder, "plot run probes.axis.u --mean 5,6", "samples are from 0");
    refused(folder, "plot monitor.kinetic_energy", "no run folder");
    refused(folder, "render run --mean 5,6", "frames are from 0 to 0.3");
    refused(folder, "render run --box 3,4,0,1", "must meet the flow");
    refused(folder, "render run --perspective", "2D");
    refused(folder, "render run --contours --field zone", "not numbers");
}

/// A lock lasts as long as any process has the file open, a child that inherited it among them.
#[test]
fn locks_of_other_programs_do_not_hinder_reading() {
    let parent = tempfile::tempdir().expect("a folder");
    let path = parent.path().join("run");
    run(&path, 2).finish(Summary::default()).expect("ended");
    let held = std::fs::File::open(path.join("particles.nc")).expect("open");
    held.lock().expect("locked");
    assert!(done(parent.path(), "info run").contains("3 from 0 s"));
    done(parent.path(), "render run --width 320 -o flow.png");
}

#[test]
fn particles_of_a_3d_flow_are_drawn_in_perspective() {
    let parent = tempfile::tempdir().expect("a folder");
    let path = parent.path().join("run");
    run(&path, 3).finish(Summary::default()).expect("ended");
    let results = Results::open(&path).expect("a run");
    let drawn = |slice: Option<Slice>| {
        let picture = parent.path().join("space.png");
        let perspective = Some([1.0, 1.0, 2.0]);
        let options =
            RenderOptions { field: Field::U, width: 640, perspective, slice, ..RenderOptions::default() };
        render(&results, None, &options, &picture).expect("drawn");
        image::open(&picture).expect("a picture").into_rgb8()
    };
    // Red is fluid with a velocity along x, which is palest where it is farthest.
    let red = |picture: &image::RgbImage| {
        picture.pixels().filter(|pixel| i32::from(pixel[0]) > i32::from(pixel[2]) + 60).count()
    };
    let (whole, half) = (red(&drawn(None)), red(&drawn(Some(Slice { axis: 0, at: None }))));
    assert!(whole > 5000 && half > whole / 5 && half < whole * 4 / 5, "{whole} and {half} pixels");
}
