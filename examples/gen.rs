fn main() {
    std::fs::write("scenarios/recordings/in_vivo_like.csv", trocar::recording::in_vivo_like_csv(1)).unwrap();
}
