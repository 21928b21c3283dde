use super::*;

#[test]
fn survey() {
    let mut watch = |_| true;
    let mut request = Request::new(&mut watch);
    request.level = Level::Regression;
    let begin = std::time::Instant::now();
    let subjects = subjects::all(request.level, 2048, 1).expect("subjects");
    println!("subjects {:?}", begin.elapsed());
    let report = check_all(&subjects, &mut request, &|subject, fault, stop| subject.fate(fault, None, stop)).expect("a report");
    report.write(Path::new("/tmp/opmut.txt")).expect("a file");
    let verdict = report.verdict();
    println!("{:?} {} {:?}", begin.elapsed(), verdict.covered, verdict.failures);
}
