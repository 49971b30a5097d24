#[test]
fn x() {
    for t in super::templates() {
        if let Err(e) = super::parse(t.text, "c.toml", &[]) {
            panic!("{e}")
        }
    }
    for s in [
        "[materials.steel]\nyoung = 1\n[mesh]\nblock={size=[1,1,1],cells=[1,1,1]}",
        "a = 1",
        "[mesh]\nfile='a'\n[materials]",
        "[[contact]]\n",
        "mesh.block.size=3",
        "[mesh]\nfile='a'\nblock={}",
        "[mesh]\nblock={}",
        "[mesh",
        "[mesh]\nblock={size=[1,1,1],cells=[1,1,-1]}",
    ] {
        println!("{}\n", super::parse(s, "c.toml", &[]).unwrap_err());
    }
}
