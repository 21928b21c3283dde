use super::*;

#[test]
fn survey() {
    let mut watch = |_| true;
    let mut request = Request::new(&mut watch);
    if std::env::var("FULL").is_ok() {
        request.level = crate::Level::Full;
    }
    let begin = std::time::Instant::now();
    let subjects = subjects::all(request.level, 2048, 1).expect("subjects");
    println!("subjects {:?}", begin.elapsed());
    let only = std::env::var("ONLY").unwrap_or_default();
    let sample = std::env::var("SAMPLE").map_or(usize::MAX, |sample| sample.parse().expect("a number"));
    let subjects: Vec<Subject> = subjects.into_iter().filter(|subject| subject.name.starts_with(&only)).collect();
    let report = check_all(&subjects, sample, &mut request, &Solver::find().expect("Z3")).expect("a report");
    report.write(Path::new("/tmp/opmut.txt")).expect("a file");
    let verdict = report.verdict();
    println!("{:?} {} {:?}", begin.elapsed(), verdict.covered, verdict.failures);
}
