#include "tests/integration/fixture.h"

#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <utility>

#include "client/relocalizer/grpc_relocalizer.h"

namespace treeline {
namespace {

namespace fs = std::filesystem;

constexpr char kScene[] = TREELINE_INTEGRATION_SCENE;

}  // namespace

std::string RecordingFolder() { return std::string(kScene) + "/recording"; }

std::string RoomModelPath() { return std::string(kScene) + "/room.treeline"; }

dataset::Dataset HeldOutFrames() {
  const auto frames =
      dataset::Dataset::Open({.uri = "7scenes:" + RecordingFolder(),
                              .frame_list = RecordingFolder() + "/test.txt"});
  EXPECT_TRUE(frames.ok()) << frames.status();
  return frames.value();
}

relocalizer::LocalizeQuery QueryOf(const dataset::Dataset& frames, int i,
                                   uint64_t seed) {
  dataset::Dataset::Encoded encoded = frames.ReadEncoded(i).value();
  relocalizer::LocalizeQuery query;
  query.scene = "room";
  query.seed = seed;
  query.frame.color = wire::EncodedImage{std::move(encoded.color)};
  query.frame.depth =
      wire::QueryDepth{.image = wire::EncodedImage{std::move(encoded.depth)}};
  return query;
}

void ServerTest::SetUp() {
  ASSERT_TRUE(fs::exists(RoomModelPath()))
      << "run the tests through ctest: integration.scene makes this file";
  const auto* test = testing::UnitTest::GetInstance()->current_test_info();
  folder_ = (fs::path(testing::TempDir()) /
             ("integration-" + std::to_string(getpid()) + "-" + test->name()))
                .string();
  models_ = folder_ + "/models";
  fs::create_directories(models_);
}

void ServerTest::TearDown() {
  client_.reset();
  server_.reset();
  std::error_code ignored;
  fs::remove_all(folder_, ignored);
}

void ServerTest::PutModel(const std::string& scene, const std::string& version,
                          const std::string& bytes) {
  PutFile("models/" + scene + "/" + version + "/model.treeline", bytes);
}

void ServerTest::PutRoom(const std::string& scene) {
  const fs::path version = fs::path(models_) / scene / "1";
  fs::create_directories(version);
  fs::create_symlink(RoomModelPath(), version / "model.treeline");
}

std::vector<std::string> ServerTest::ServerCommand() const {
  return {TREELINE_SERVER_PROGRAM,
          "--models",
          models_,
          "--load-all",
          "--listen",
          "127.0.0.1:0",
          "--admin-listen",
          "127.0.0.1:0",
          "--http-listen",
          "127.0.0.1:0"};
}

void ServerTest::StartServer(const std::vector<std::string>& more_arguments) {
  std::vector<std::string> command = ServerCommand();
  if (more_arguments.empty()) {
    command.insert(command.end(), {"--drain-s", "0"});
  }
  command.insert(command.end(), more_arguments.begin(), more_arguments.end());
  server_ = std::make_unique<Process>(command);
  const std::string prefix = "listening on ";
  const auto line = server_->WaitForLine(prefix);
  ASSERT_TRUE(line.has_value()) << server_->err();
  address_ = line->substr(prefix.size());
  auto client = relocalizer::ConnectRelocalizer({.server = address_});
  ASSERT_TRUE(client.ok()) << client.status();
  client_ = *std::move(client);
}

ProgramResult ServerTest::RunClient(
    const std::string& command,
    const std::vector<std::string>& arguments) const {
  std::vector<std::string> argv = {TREELINE_CLIENT_PROGRAM, command, "--server",
                                   address_};
  argv.insert(argv.end(), arguments.begin(), arguments.end());
  return RunProgram(argv);
}

std::string ServerTest::PutFile(const std::string& name,
                                const std::string& bytes) {
  const fs::path path = fs::path(folder_) / name;
  fs::create_directories(path.parent_path());
  std::ofstream(path, std::ios::binary) << bytes;
  return path.string();
}

}  // namespace treeline
