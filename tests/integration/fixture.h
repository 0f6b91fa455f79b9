// The real programs on a real socket, and a small trained scene.
#ifndef TESTS_INTEGRATION_FIXTURE_H_
#define TESTS_INTEGRATION_FIXTURE_H_

#include <memory>
#include <string>
#include <vector>

#include "client/relocalizer/relocalizer.h"
#include "common/dataset/dataset.h"
#include "gtest/gtest.h"
#include "tests/integration/process.h"

namespace treeline {

// What the fixture test `integration.scene` made: a recording of a synthetic
// room, and a model of it.
std::string RecordingFolder();
std::string RoomModelPath();

// The held-out frames of the recording.
dataset::Dataset HeldOutFrames();

// A query for frame i, sent as the files are.
relocalizer::LocalizeQuery QueryOf(const dataset::Dataset& frames, int i,
                                   uint64_t seed = 0);

// A folder with scenes, and servers on it.
class ServerTest : public testing::Test {
 protected:
  void SetUp() override;
  void TearDown() override;

  // Adds a scene with these bytes as its model.
  void PutModel(const std::string& scene, const std::string& version,
                const std::string& bytes);
  // Adds the trained scene, without copying it.
  void PutRoom(const std::string& scene = "room");

  // Starts treeline-server on the folder and waits until it serves.
  // --drain-s 0 unless told otherwise.
  void StartServer(const std::vector<std::string>& more_arguments = {});
  // The arguments of a server on the folder, on a free port.
  std::vector<std::string> ServerCommand() const;

  // Runs treeline-client with `arguments` and the server's address.
  ProgramResult RunClient(const std::string& command,
                          const std::vector<std::string>& arguments) const;

  // Puts a file with these bytes; returns its path.
  std::string PutFile(const std::string& name, const std::string& bytes);

  std::string folder_;  // of everything
  std::string models_;
  std::string address_;
  std::unique_ptr<Process> server_;
  std::unique_ptr<relocalizer::Relocalizer> client_;
};

}  // namespace treeline

#endif  // TESTS_INTEGRATION_FIXTURE_H_
