//! Damaged files of all formats: no panic, a message, and memory in proportion to the file.
//!
//! There is one test: another one at the same time would disturb the count of the allocator.

use peak_alloc::PeakAlloc;
use sphecs_mesh::{Facets, Part, Surface, read};

#[global_allocator]
static ALLOCATOR: PeakAlloc = PeakAlloc;

/// Damaged files in all.
const FILES: usize = 1_000_000;

/// Largest memory for a file, in its sizes, beside some for messages and small buffers.
const TIMES: usize = 20;
const BESIDE: usize = 16 << 10;

/// One in this many of the files that are read becomes a surface.
const SURFACES: usize = 16;

struct Random(u64);

impl Random {
    fn below(&mut self, end: usize) -> usize {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 20) as usize % end.max(1)
    }
}

const POINTS: [[f64; 3]; 5] =
    [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 1.0, 0.25]];
const TRIANGLES: [[usize; 3]; 6] = [[0, 2, 1], [0, 1, 3], [1, 4, 3], [2, 0, 3], [4, 2, 3], [1, 2, 4]];

fn binary_stl() -> Vec<u8> {
    let mut bytes = b"solid made by a program".to_vec();
    bytes.resize(80, b' ');
    bytes.extend((TRIANGLES.len() as u32).to_le_bytes());
    for triangle in TRIANGLES {
        bytes.extend([0; 12]);
        let numbers = triangle.iter().flat_map(|vertex| POINTS[*vertex]);
        bytes.extend(numbers.flat_map(|x| (x as f32).to_le_bytes()));
        bytes.extend([0; 2]);
    }
    bytes
}

fn text_stl() -> Vec<u8> {
    let mut text = String::new();
    for (number, triangle) in TRIANGLES.iter().enumerate() {
        let corner = |at: usize| POINTS[triangle[at]].map(|x| x.to_string()).join(" ");
        text += &format!(
            "solid s{number}\nfacet normal 0 0 1\nouter loop\nvertex {}\nvertex {}\nvertex {}\nendloop\n\
             endfacet\nendsolid\n",
            corner(0),
            corner(1),
            corner(2)
        );
    }
    text.into_bytes()
}

fn obj() -> Vec<u8> {
    let mut text = String::from("# box\no a\n");
    POINTS.iter().for_each(|[x, y, z]| text += &format!("v {x} {y} {z}\n"));
    for [a, b, c] in TRIANGLES {
        text += &format!("g g{a}\nf {}/1/1 {}//2 {}\n", a + 1, b + 1, c as i64 - 5);
    }
    (text + "f 1 2 5 3 \\\n 4\n").into_bytes()
}

fn ply(format: &str, is_big: bool) -> Vec<u8> {
    let mut bytes = format!(
        "ply\nformat {format} 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty float z\n\
         property list uchar short tags\nelement face {}\nproperty list uchar ushort vertex_indices\nend_header\n",
        POINTS.len(),
        TRIANGLES.len()
    )
    .into_bytes();
    let mut put = |text: String, mut raw: Vec<u8>| {
        if is_big {
            raw.reverse();
        }
        bytes.extend(if format == "ascii" { (text + " ").into_bytes() } else { raw });
    };
    for point in POINTS {
        point.iter().for_each(|x| put(x.to_string(), (*x as f32).to_le_bytes().to_vec()));
        put("1".to_owned(), vec![1]);
        put("7".to_owned(), vec![7, 0]);
    }
    for triangle in TRIANGLES {
        put("3".to_owned(), vec![3]);
        triangle.iter().for_each(|v| put(v.to_string(), vec![*v as u8, 0]));
    }
    bytes
}

/// Words and numbers that readers take special care of.
const PIECES: [&[u8]; 24] = [
    b"\n",
    b" ",
    b"\r\n",
    b"\0",
    b"\xff\xff\xff\xff",
    b"nan",
    b"1e400",
    b"-1",
    b"99999999999",
    b"solid ",
    b"endsolid",
    b"facet ",
    b"vertex ",
    b"f 1 2 3 4 5\n",
    b"v 1 2 3\n",
    b"g x\n",
    b"\\\n",
    b"/",
    b"#",
    b"element face 99999999\n",
    b"property list uchar uchar vertex_index\n",
    b"end_header\n",
    b"list ",
    b"element x 4000000000\n",
];

/// Damages a file in one to four places.
fn damage(bytes: &mut Vec<u8>, random: &mut Random) {
    for _ in 0..=random.below(4) {
        let at = random.below(bytes.len());
        let end = (at + 1 + random.below(12)).min(bytes.len());
        match random.below(7) {
            0 if at < bytes.len() => bytes[at] ^= 1 << random.below(8),
            1 if at < bytes.len() => bytes[at] = random.below(256) as u8,
            2 => drop(bytes.drain(at.min(end)..end)),
            3 => {
                let piece = PIECES[random.below(PIECES.len())];
                drop(bytes.splice(at..at, piece.iter().copied()));
            }
            4 => {
                let copy = bytes[at.min(end)..end].to_vec();
                let to = random.below(bytes.len());
                drop(bytes.splice(to..to, copy));
            }
            5 if random.below(8) == 0 => bytes.truncate(at),
            _ => {
                let number = random.below(300).to_string();
                drop(bytes.splice(at.min(end)..end, number.bytes()));
            }
        }
    }
}

/// Files with as little text as possible for what is kept of them.
fn dense() -> Vec<(&'static str, Vec<u8>)> {
    let count = 60_000;
    let stl: String = (0..count).map(|at| format!("solid {at}\nendsolid\n")).collect();
    let points = "v 0 0 0\n".repeat(50) + "v 1 0 0\nv 0 1 0\n";
    let triangles = points.clone() + &"f 1 2 3\n".repeat(count);
    let polygons = points.clone() + &format!("f{}\n", " 9".repeat(100)).repeat(count / 10);
    let groups = points + &(0..count).map(|at| format!("g {at}\nf 1 2 3\n")).collect::<String>();
    let header = |format: &str, list: &str, points: usize, faces: usize| {
        format!(
            "ply\nformat {format} 1.0\nelement vertex {points}\nproperty char x\nproperty char y\n\
             property char z\nelement face {faces}\nproperty list {list} vertex_index\nend_header\n"
        )
        .into_bytes()
    };
    let mut many = header("binary_little_endian", "uchar uchar", 200, count / 10);
    many.extend((0..200).flat_map(|at| [at, 3, at / 2]));
    // 200 corners with numbers of one byte.
    (0..count / 10).for_each(|_| many.extend([200].into_iter().chain(0..200)));
    let mut round = header("binary_little_endian", "uint uint", count, 1);
    round.extend((0..count).flat_map(|at| [at as u8, (at / 256) as u8, 0]));
    round.extend((count as u32).to_le_bytes());
    round.extend((0..count as u32).flat_map(u32::to_le_bytes));
    vec![
        ("solids.stl", stl.into_bytes()),
        ("triangles.obj", triangles.into_bytes()),
        ("polygons.obj", polygons.into_bytes()),
        ("groups.obj", groups.into_bytes()),
        ("many.ply", many),
        ("round.ply", round),
    ]
}

/// Returns the largest memory that reading a file takes, B.
fn peak(bytes: &[u8], name: &str) -> usize {
    let before = ALLOCATOR.current_usage();
    ALLOCATOR.reset_peak_usage();
    let _ = read(bytes, name);
    ALLOCATOR.peak_usage() - before
}

/// Makes a surface where that is possible, and asserts what holds for every surface.
fn query(facets: Facets) {
    let part = Part { name: "a".to_owned(), facets };
    let Ok((surface, report)) = Surface::new(vec![part], 1e-3) else { return };
    assert_eq!(surface.triangles().len(), report.triangles);
    let dropped = report.degenerate + report.duplicates + report.opposite;
    assert_eq!(report.facets, report.triangles + dropped, "{report:?}");
    let (low, high) = surface.bounds();
    for share in [-0.5, 0.3, 0.5] {
        let point = low + share * (high - low);
        let nearest = surface.nearest(point);
        assert!(nearest.distance.is_finite() && surface.winding(point).is_finite());
        assert_eq!(surface.signed_distance(point).abs(), nearest.distance);
        assert!(surface.smooth_normal_at(point, &nearest).is_finite());
    }
    assert!(surface.planes().iter().all(|plane| plane.offset.is_finite() && plane.normal.is_finite()));
    assert!(surface.intersections().place.is_none_or(|place| place.is_finite()));
    assert!(report.lines().iter().all(|line| !line.contains("NaN")), "{:?}", report.lines());
}

#[test]
fn damaged_files_are_read_or_refused_in_little_memory() {
    let files = [
        ("a.stl", binary_stl()),
        ("a.stl", text_stl()),
        ("a.obj", obj()),
        ("a.ply", ply("ascii", false)),
        ("a.ply", ply("binary_little_endian", false)),
        ("a.ply", ply("binary_big_endian", true)),
    ];
    for (name, bytes) in &files {
        assert!(read(bytes, name).is_ok(), "{name}: {:?}", read(bytes, name).err());
    }
    for (name, bytes) in dense() {
        let times = peak(&bytes, name) as f64 / bytes.len() as f64;
        println!("{name}: {times:.1} times the file");
        assert!(times <= TIMES as f64, "{name}: {times} times the file");
    }
    let mut random = Random(0x2545_f491_4f6c_dd1d);
    let (mut good, mut refused) = ([0; 6], [0; 6]);
    for number in 0..FILES {
        let kind = number % files.len();
        let (name, mut bytes) = files[kind].clone();
        damage(&mut bytes, &mut random);
        let before = ALLOCATOR.current_usage();
        ALLOCATOR.reset_peak_usage();
        let result = read(&bytes, name);
        let most = ALLOCATOR.peak_usage() - before;
        let text = || String::from_utf8_lossy(&bytes).into_owned();
        assert!(most <= TIMES * bytes.len() + BESIDE, "{most} bytes for {}: {}", bytes.len(), text());
        match result {
            Ok(facets) => {
                good[kind] += 1;
                if good[kind] % SURFACES == 0 {
                    query(facets);
                }
            }
            Err(fault) => {
                refused[kind] += 1;
                let message = fault.to_string();
                assert!((20..400).contains(&message.len()) && !message.contains('\n'), "{message}");
            }
        }
    }
    // Damage that always or never counts would test little.
    for kind in 0..files.len() {
        let share = f64::from(refused[kind]) / f64::from(refused[kind] + good[kind] as i32);
        assert!((0.1..0.99).contains(&share), "{}: {share}", files[kind].0);
    }
}
