//! Files of rays and hits: what is written is read, and wrong lines are errors.

use raypath_ops::{Binary32, Ray};
use raypath_render::{
    Hit, Mesh, Scene, Tracing, parse_hits, parse_rays, read_rays, trace_closest, write_hits, write_rays,
};
use raypath_tools::MemoryLimit;
use std::path::Path;

#[test]
fn rays_are_read() {
    let text = "# two rays\n\n1 2 3  0 0 -1 inf\n-1e3 .5 0\t1 1 1 2.5 # the second\r\n";
    let rays = parse_rays(text, Path::new("rays")).unwrap();
    let numbers: Vec<[f32; 7]> = rays
        .iter()
        .map(|ray| {
            let ([ox, oy, oz], [dx, dy, dz]): ([f32; 3], [f32; 3]) = (ray.origin.into(), ray.dir.into());
            [ox, oy, oz, dx, dy, dz, ray.extent.into()]
        })
        .collect();
    assert_eq!(numbers, [[1.0, 2.0, 3.0, 0.0, 0.0, -1.0, f32::INFINITY], [-1e3, 0.5, 0.0, 1.0, 1.0, 1.0, 2.5]]);
    assert!(parse_rays("# none\n", Path::new("rays")).unwrap().is_empty());
}

#[test]
fn invalid_rays_are_errors() {
    for (line, message) in [
        ("1 2 3 0 0 -1", "6 numbers, expected 7: ox oy oz dx dy dz extent"),
        ("1 2 3 0 0 -1 inf 8", "8 numbers, expected 7: ox oy oz dx dy dz extent"),
        ("1 2 3 0 y -1 inf", "dy = 'y', expected a decimal number"),
        ("1 2 3 0 0 -1 0x8", "extent = '0x8', expected a decimal number"),
        ("1 2 3 0 0 0 inf", "direction (0, 0, 0) is zero, expected a direction of any other length"),
        ("1 2 nan 0 0 1 inf", "origin (1, 2, NaN) is not finite, expected three finite numbers"),
        (
            "1 2 3 0 0 1 -1",
            "extent -1 is not a valid distance, expected a number of at least 0 (infinity reaches everything)",
        ),
        ("1 2 3 0 1e39 1 1", "direction (0, inf, 1) is not finite, expected three finite numbers"),
    ] {
        let problem = parse_rays(&format!("# first\n{line}\n"), Path::new("a/rays.txt")).unwrap_err();
        assert_eq!(problem.to_string(), format!("a/rays.txt:2: {message}"));
    }
    let absent = read_rays(Path::new("a/absent.txt"), MemoryLimit::DEFAULT).unwrap_err().to_string();
    assert!(absent.starts_with("a/absent.txt: cannot read: "), "{absent}");
}

#[test]
fn hits_are_written_exactly() {
    let mesh = Mesh::new(vec![[0.0, 0.0, 0.1], [1.0, 0.0, 0.2], [0.0, 1.0, 0.3]], vec![[0, 1, 2]]).unwrap();
    let rays =
        parse_rays("0.1 0.2 5 0 0 -0.7 inf\n9 9 9 0 0 1 inf\n0.1 0.2 -5 0.01 0 1.3 inf", Path::new("rays")).unwrap();
    let tracing = Tracing { two_sided: true, ..Tracing::default() };
    let (hits, _) = trace_closest(&Scene::new(mesh).unwrap(), &rays, tracing, &|_| true).unwrap();
    let mut text = Vec::new();
    write_hits(&mut text, &hits).unwrap();
    let text = String::from_utf8(text).unwrap();
    let lines: Vec<&str> = text.lines().filter(|line| !line.starts_with('#')).collect();
    assert_eq!(lines.len(), 3);
    assert_eq!(lines[1], "miss");
    for (line, hit, triangle) in [(lines[0], hits[0], "0"), (lines[2], hits[2], "0b")] {
        let Hit { t, t_num, t_denom, .. } = hit.unwrap();
        let words: Vec<&str> = line.split(' ').collect();
        assert_eq!((words.len(), words[0]), (7, triangle));
        for (field, number) in [t, t_num, t_denom].into_iter().enumerate() {
            assert_eq!(words[1 + field].parse::<f32>().unwrap().to_bits(), number.to_bits());
            assert_eq!(u32::from_str_radix(words[4 + field], 16).unwrap(), number.to_bits());
        }
        assert_eq!(t, t_num / t_denom);
    }
    assert_eq!(parse_hits(&text, Path::new("hits")), Ok(hits));
}

#[test]
fn rays_are_written_exactly() {
    let (tiny, third) = (f32::from_bits(1), 1.0_f32 / 3.0);
    let rays =
        [([-0.0, tiny, 1e38], [third, -third, 1e-30], 2.0 * third), ([third; 3], [0.0, 0.0, 1.0], f32::INFINITY)];
    let rays = rays.map(|(origin, direction, extent)| Ray::new(origin, direction, extent).unwrap());
    let mut text = Vec::new();
    write_rays(&mut text, &rays).unwrap();
    let text = String::from_utf8(text).unwrap();
    let read = parse_rays(&text, Path::new("rays")).unwrap();
    let bits = |ray: &Ray<Binary32>| {
        let (origin, direction): ([f32; 3], [f32; 3]) = (ray.origin.into(), ray.dir.into());
        (origin.map(f32::to_bits), direction.map(f32::to_bits), f32::from(ray.extent).to_bits())
    };
    assert_eq!(read.iter().map(bits).collect::<Vec<_>>(), rays.iter().map(bits).collect::<Vec<_>>());
}
