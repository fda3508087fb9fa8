use super::*;

#[test]
fn columns_in_memory_are_read_as_a_file_is() {
    let names = ["t_ms", "tip_x_mm", "tip_z_mm", "note"].map(str::to_owned);
    let columns =
        [vec![0.0, 10.0, 20.0], vec![1.0, 2.0, f64::NAN], vec![4.0, 5.0, 6.0], vec![0.0; 3]].map(Ok);
    let read = |options: &ReadOptions| table(&names, &columns, Path::new("made"), options);
    let made = read(&ReadOptions::default()).unwrap();
    assert_eq!(made.time, [0.0, 0.01, 0.02]);
    assert_eq!(made.markers[0].position, [Some([0.001, 0.0, 0.004]), Some([0.002, 0.0, 0.005]), None]);
    assert!(made.findings.iter().any(|finding| finding.contains("passed over: `note`")), "{made:?}");
    let rows = "t_ms,tip_x_mm,tip_z_mm,note\n0,1,4,0\n10,2,5,0\n20,,6,0\n";
    let file = super::super::parse(rows.into(), Path::new("a.csv"), &ReadOptions::default()).unwrap();
    assert_eq!((file.time, file.rate_hz), (made.time, made.rate_hz));
    assert_eq!(file.markers[0].position, made.markers[0].position);
    let metres = ReadOptions { unit: Some(Length::Metre), ..Default::default() };
    assert_eq!(read(&metres).unwrap().markers[0].position[0], Some([1.0, 0.0, 4.0]));
}
