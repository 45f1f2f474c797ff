// SPDX-License-Identifier: BSD-3-Clause
#include "live/live_window.h"

#include "live/live_picture.h"

#include <vtkCallbackCommand.h>
#include <vtkCommand.h>
#include <vtkNew.h>
#include <vtkRenderWindow.h>
#include <vtkXRenderWindowInteractor.h>  // the last one: it defines macros of X

#include <utility>

namespace facetloc {
namespace {

constexpr int kWidth = 1280, kHeight = 764;  // [px] a screenshot and two lines
constexpr double kStill = 4;                 // a mouse that moves less while pressed clicks [px]
constexpr double kZoomStep = 1.2;
constexpr const char* kResetKey = "v";

struct Key {
  const char* name;
  LiveCommand command;
};
constexpr Key kKeys[] = {{"s", LiveCommand::screenshot}, {"r", LiveCommand::record},
                         {"p", LiveCommand::pause},      {"space", LiveCommand::pause},
                         {"l", LiveCommand::relocalize}, {"q", LiveCommand::quit},
                         {"Escape", LiveCommand::quit}};

}  // namespace

std::optional<LiveCommand> commandOf(const std::string& key) {
  for (const Key& known : kKeys)
    if (key == known.name) return known.command;
  return {};
}

std::string keysText() {
  return "s screenshot,  r record on/off,  p or space pause,  l relocalize,  q quit;  "
         "mouse: left turns, right moves, wheel zooms, click tells;  v view as before";
}

struct LiveWindow::Insides {
  explicit Insides(std::shared_ptr<const Map> map) : picture(window, std::move(map)) {}

  static void onEvent(vtkObject*, unsigned long event, void* self, void*) {
    auto& insides = *static_cast<Insides*>(self);
    if (event == vtkCommand::ExitEvent) {
      insides.asked.push_back(LiveCommand::quit);
      return;
    }
    if (event != vtkCommand::KeyPressEvent) return insides.onMouse(event);
    const char* key = insides.interactor->GetKeySym();
    if (key && std::string(key) == kResetKey) return insides.picture.looks().reset();
    if (const auto command = commandOf(key ? key : "")) insides.asked.push_back(*command);
  }

  /** Left turns, or moves with shift; the others move; a press that does not move is a click. */
  void onMouse(unsigned long event) {
    const int* position = interactor->GetEventPosition();
    const Eigen::Vector2d at(position[0], window->GetSize()[1] - 1 - position[1]);
    LiveLooks& looks = picture.looks();
    if (event == vtkCommand::MouseWheelForwardEvent) return looks.zoom(at, kZoomStep);
    if (event == vtkCommand::MouseWheelBackwardEvent) return looks.zoom(at, 1 / kZoomStep);
    if (event == vtkCommand::MouseMoveEvent) {
      if (!pressed || (!moved && (at - *pressed).norm() < kStill)) return;
      looks.drag(*pressed, moved ? last : *pressed, at, how);
      moved = true;
      last = at;
      return;
    }
    const bool left = event == vtkCommand::LeftButtonPressEvent;
    if (left || event == vtkCommand::RightButtonPressEvent || event == vtkCommand::MiddleButtonPressEvent) {
      pressed = last = at;
      moved = false;
      how = left && !interactor->GetShiftKey() ? LiveLooks::Drag::turn : LiveLooks::Drag::move;
      return;
    }
    if (pressed && !moved) picture.choose(at);
    pressed.reset();
  }

  vtkNew<vtkRenderWindow> window;
  vtkNew<vtkXRenderWindowInteractor> interactor;
  std::optional<Eigen::Vector2d> pressed;  // where a button went down; nothing if none is
  Eigen::Vector2d last = Eigen::Vector2d::Zero();
  bool moved = false;
  LiveLooks::Drag how = LiveLooks::Drag::turn;
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
  for (const auto event : {vtkCommand::KeyPressEvent, vtkCommand::ExitEvent, vtkCommand::LeftButtonPressEvent,
                           vtkCommand::LeftButtonReleaseEvent, vtkCommand::MiddleButtonPressEvent,
                           vtkCommand::MiddleButtonReleaseEvent, vtkCommand::RightButtonPressEvent,
                           vtkCommand::RightButtonReleaseEvent, vtkCommand::MouseMoveEvent,
                           vtkCommand::MouseWheelForwardEvent, vtkCommand::MouseWheelBackwardEvent})
    interactor->AddObserver(event, callback);
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
