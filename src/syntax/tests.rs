use super::*;
#[test]
fn dump() {
    let text = std::fs::read_to_string(std::env::var("TWZ").unwrap()).unwrap();
    let mut sink = Sink::default();
    let tree = parse(FileId(0), &text, &mut sink);
    if std::env::var("TREE").is_ok() {
        println!("{tree:#?}");
    }
    for d in sink.sorted() {
        println!("{} {} ", d.code, d.title);
        for l in &d.labels {
            let line = text[..l.span.start as usize].matches('\n').count() + 1;
            println!("    line {line} {:?} `{}` {}", l.span, &text[l.span.range()], l.text);
        }
        println!("    help {:?}", d.help);
    }
}
