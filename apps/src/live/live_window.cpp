// SPDX-License-Identifier: BSD-3-Clause
#include "live/live_window.h"

#include "live/live_picture.h"

#include <vtkCallbackCommand.h>
#include <vtkCommand.h>
#include <vtkNew.h>
#include <vtkRenderWindow.h>
#include <vtkXRenderWindowInteractor.h>  // the last one: it defines macros of X

#include <array>
#include <utility>

namespace facetloc {
namespace {

constexpr int kWidth = 1280, kHeight = 764;  // [px] a screenshot and two lines

struct Key {
  const char* name;
  LiveCommand command;
};
constexpr std::array<Key, 7> kKeys = {{{"s", LiveCommand::screenshot},
                                       {"r", LiveCommand::record},
                                       {"p", LiveCommand::pause},
                                       {"space", LiveCommand::pause},
                                       {"l", LiveCommand::relocalize},
                                       {"q", LiveCommand::quit},
                                       {"Escape", LiveCommand::quit}}};

}  // namespace

std::optional<LiveCommand> commandOf(const std::string& key) {
  for (const Key& known : kKeys)
    if (key == known.name) return known.command;
  return {};
}

std::string keysText() { return "s screenshot,  r record on/off,  p or space pause,  l relocalize,  q quit"; }

struct LiveWindow::Insides {
  explicit Insides(std::shared_ptr<const Map> map) : picture(window, std::move(map)) {}

  static void onEvent(vtkObject*, unsigned long event, void* self, void*) {
    auto& insides = *static_cast<Insides*>(self);
    if (event == vtkCommand::ExitEvent) {
      insides.asked.push_back(LiveCommand::quit);
      return;
    }
    const char* key = insides.interactor->GetKeySym();
    if (const auto command = commandOf(key ? key : "")) insides.asked.push_back(*command);
  }

  vtkNew<vtkRenderWindow> window;
  vtkNew<vtkXRenderWindowInteractor> interactor;
  LivePicture picture;
  std::vector<LiveCommand> asked;
};

LiveWindow::LiveWindow(const std::string& title, std::shared_ptr<const Map> map)
    : insides_(std::make_unique<Insides>(std::move(map))) {
  vtkRenderWindow* window = insides_->window;
  window->SetMultiSamples(0);  // as in files
  window->SetSize(kWidth, kHeight);
  window->SetWindowName(title.c_str());
  vtkRenderWindowInteractor* interactor = insides_->interactor;
  interactor->SetRenderWindow(window);
  interactor->SetInteractorStyle(nullptr);  // its keys are not ours
  vtkNew<vtkCallbackCommand> callback;
  callback->SetClientData(insides_.get());
  callback->SetCallback(Insides::onEvent);
  interactor->AddObserver(vtkCommand::KeyPressEvent, callback);
  interactor->AddObserver(vtkCommand::ExitEvent, callback);
  interactor->Initialize();
}

LiveWindow::~LiveWindow() { insides_->interactor->RemoveAllObservers(); }

void LiveWindow::show(const LiveResult& result, const std::vector<std::string>& footer) {
  std::vector<std::string> lines = footer;
  lines.push_back(keysText());
  insides_->picture.show(result, lines);
}

std::vector<LiveCommand> LiveWindow::commands() {
  insides_->interactor->ProcessEvents();
  return std::exchange(insides_->asked, {});
}

void LiveWindow::press(const std::string& key) {
  insides_->interactor->SetKeySym(key.c_str());
  insides_->interactor->InvokeEvent(vtkCommand::KeyPressEvent);
}

}  // namespace facetloc
